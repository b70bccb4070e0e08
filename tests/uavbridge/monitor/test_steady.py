import os

from uavbridge.monitor.steady import SteadyConsole


def test_it_outlives_its_reader() -> None:
    reader, writer = os.pipe()
    with os.fdopen(writer, "w") as file:
        console = SteadyConsole(file=file)
        console.print("first")
        os.close(reader)
        console.print("nobody hears this")
        console.print("nor this")
        file.write("nor what goes there without the console")
