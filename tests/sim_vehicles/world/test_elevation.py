"""Elevation files: what is read, and what is said of odd ones."""

import numpy as np
import pytest

from sim_vehicles.geodesy import Geodetic
from sim_vehicles.world.elevation import read

GRID = """ncols 3
nrows 2
xllcorner 500000
yllcorner 100
cellsize 10
NODATA_value -9999
4 5 6
1 2 3
"""


def written(folder, text, name="hills.asc"):
    path = folder / name
    path.write_text(text)
    return path


def test_an_ascii_grid_runs_from_north_to_south(tmp_path):
    terrain = read(written(tmp_path, GRID), south_west=(-5.0, 7.0))
    assert terrain.heights.tolist() == [[1, 4], [2, 5], [3, 6]]
    assert terrain.bounds == (-5.0, 7.0, 15.0, 17.0)


def test_an_array_file(tmp_path):
    np.save(tmp_path / "hills.npy", np.arange(6, dtype=np.int16).reshape(3, 2))
    terrain = read(tmp_path / "hills.npy", cell_m=4.0)
    assert terrain.heights.tolist() == [[0, 1], [2, 3], [4, 5]]
    assert terrain.bounds == (0.0, 0.0, 8.0, 4.0)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("4 5 6", "4 -9999 6", "1 of 6 heights are missing, the first at column 1, row 1"),
        ("4 5 6", "4 nan 6", "1 of 6 heights are missing"),
        ("NODATA_value -9999\n4 5 6", "NODATA_value -1\n4 -32768 6", "1 of 6 heights are missing"),
        ("4 5 6", "4 5", "says ncols 3, and row 1 has 2 numbers"),
        ("4 5 6\n", "", "says nrows 2 and has 1 rows"),
        ("4 5 6", "4 x 6", "a height is not a number"),
        ("cellsize 10\n", "", "cellsize is missing"),
        ("cellsize 10", "cellsize ten", "cellsize is 'ten'"),
        ("cellsize 10", "cellsize -1", "spacing must be positive"),
        ("cellsize 10", "dx 10\ndy 12", "not square"),
        ("ncols 3", "ncols 2.5", "ncols must be a whole number"),
        ("ncols 3", "columns 3", "ncols must be a whole number"),
    ],
)
def test_odd_grids_are_named(tmp_path, old, new, words):
    with pytest.raises(ValueError, match=f"hills.asc: .*{words}"):
        read(written(tmp_path, GRID.replace(old, new)))


def test_files_that_are_none(tmp_path):
    with pytest.raises(ValueError, match=r"lost.asc: No such file"):
        read(tmp_path / "lost.asc")
    with pytest.raises(ValueError, match=r"hills.xyz: not an elevation file that we know"):
        read(written(tmp_path, GRID, "hills.xyz"))
    with pytest.raises(ValueError, match=r"hills.npy: .*cell_m"):
        read(written(tmp_path, GRID, "hills.npy"))
    with pytest.raises(ValueError, match=r"hills.npy: not an .npy file"):
        read(written(tmp_path, GRID, "hills.npy"), cell_m=1.0)
    np.save(tmp_path / "voids.npy", np.array([[1, -9999], [2, 3]]))
    with pytest.raises(ValueError, match=r"voids.npy: 1 of 4 heights are missing"):
        read(tmp_path / "voids.npy", cell_m=1.0)
    np.save(tmp_path / "text.npy", np.array(["a", "b"]))
    with pytest.raises(ValueError, match=r"text.npy: does not hold numbers"):
        read(tmp_path / "text.npy", cell_m=1.0)


@pytest.mark.filterwarnings("ignore::PendingDeprecationWarning")  # of rasterio itself
class TestGeoTiff:
    @pytest.fixture
    def tiff(self, tmp_path):
        rasterio = pytest.importorskip("rasterio")
        from rasterio.transform import from_origin

        def write(heights, crs, west, north, step, nodata=None, change=None, **profile):
            rows, columns = heights.shape
            path = tmp_path / "hills.tif"
            given = {"driver": "GTiff", "dtype": "float32", "count": 1, "nodata": nodata}
            given["transform"] = from_origin(west, north, *step)
            with rasterio.open(
                path, "w", width=columns, height=rows, crs=crs, **{**given, **profile}
            ) as raster:
                for band in raster.indexes:
                    raster.write(heights.astype(raster.dtypes[0]), band)
                if change is not None:
                    change(raster)
            return path

        return write

    def test_in_metres(self, tiff):
        path = tiff(np.array([[4, 5, 6], [1, 2, 3]]), "EPSG:32632", 500000.0, 5e6, (30.0, 30.0))
        terrain = read(path)
        assert terrain.heights.tolist() == [[1, 4], [2, 5], [3, 6]]
        assert terrain.bounds == (0.0, 0.0, 60.0, 30.0)
        home = Geodetic(45.15, 9.0)  # on the zone's middle meridian
        placed = read(path, origin=home)
        assert placed.west_m == pytest.approx(15.0, abs=0.1)
        assert abs(placed.south_m) < 20_000.0

    def test_in_degrees(self, tiff):
        step = 1.0 / 3600.0
        heights = np.add.outer(np.arange(60.0)[::-1], np.zeros(50))  # rises to the north
        path = tiff(heights, "EPSG:4326", 9.0, 45.0 + 60 * step, (step, step))
        home = Geodetic(45.0 + step / 2, 9.0 + step / 2)  # on the south-western sample
        terrain = read(path, origin=home)
        assert (terrain.west_m, terrain.south_m) == pytest.approx((0.0, 0.0), abs=1e-6)
        assert terrain.cell_m == pytest.approx(21.9, abs=0.1)
        assert terrain.gradient_at((500.0, 900.0)) == pytest.approx((0.0, 1 / 30.87), abs=1e-4)

    def test_holes(self, tiff):
        path = tiff(np.array([[4, -1, 6], [1, 2, 3]]), "EPSG:32632", 0.0, 60.0, (30.0, 30.0), -1)
        with pytest.raises(ValueError, match=r"hills.tif: .*1 of 6 heights are missing"):
            read(path)

    def test_cells_that_are_not_square(self, tiff):
        path = tiff(np.ones((3, 3)), "EPSG:32632", 0.0, 60.0, (30.0, 20.0))
        with pytest.raises(ValueError, match=r"hills.tif: cells are not square"):
            read(path)

    @pytest.mark.parametrize(
        ("crs", "words"),
        [
            ("EPSG:2263", "its coordinates are in US survey foot, not in metres"),
            ("EPSG:4978", "neither degrees nor metres of a projection"),
            ('LOCAL_CS["site",UNIT["metre",1]]', "neither degrees nor metres of a projection"),
            ("EPSG:4807", "its coordinates are in grad, not in degrees"),
            ("EPSG:3857", r"not true at .* home \(a metre is 1.42 m long, north is 0.0"),
            ("EPSG:32652", "not true at the mission's home"),
            ("+proj=eqc +R=1737400 +units=m +no_defs", "do not lead to the mission's home"),
        ],
    )
    def test_coordinates_that_are_of_no_use(self, tiff, crs, words):
        path = tiff(np.ones((3, 3)), crs, 465000.0, 5249605.0, (10.0, 10.0))
        with pytest.raises(ValueError, match=f"hills.tif: .*{words}"):
            read(path, origin=Geodetic(45.0, 9.0))

    def test_a_place_that_is_given_needs_no_coordinates(self, tiff):
        path = tiff(np.ones((3, 3)), "EPSG:3857", 465000.0, 5249605.0, (10.0, 10.0))
        terrain = read(path, origin=Geodetic(45.0, 9.0), south_west=(-5.0, 7.0))
        assert terrain.bounds == (-5.0, 7.0, 15.0, 27.0)

    @pytest.mark.parametrize(
        ("profile", "words"),
        [
            ({"count": 3}, "has 3 bands, and heights are one"),
            ({"dtype": "complex64"}, "does not hold numbers"),
            ({"transform": (10.0, 1.0, 0.0, 1.0, -10.0, 0.0)}, "sheared or mirrored"),
            ({"transform": (10.0, 0.0, 0.0, 0.0, 10.0, 0.0)}, "sheared or mirrored"),
            ({"transform": (1.0, 0.0, 0.0, 0.0, 1.0, 0.0)}, "does not say where its cells lie"),
        ],
    )
    @pytest.mark.filterwarnings("ignore:The given matrix")
    def test_odd_rasters(self, tiff, profile, words):
        from rasterio.transform import Affine

        if "transform" in profile:
            profile = {"transform": Affine(*profile["transform"])}
        path = tiff(np.ones((3, 3)), "EPSG:32632", 0.0, 60.0, (10.0, 10.0), **profile)
        with pytest.raises(ValueError, match=f"hills.tif: .*{words}"):
            read(path)

    def test_heights_in_other_units_of_theirs(self, tiff):
        def decimetres(raster):
            raster.scales, raster.offsets = (0.1,), (100.0,)

        heights = np.array([[40, 50], [10, 20]])
        path = tiff(heights, None, 0, 9, (5, 5), dtype="int16", change=decimetres)
        assert read(path).heights == pytest.approx(np.array([[101.0, 104.0], [102.0, 105.0]]))

    def test_holes_that_only_a_mask_tells(self, tiff):
        def mask(raster):
            raster.write_mask(np.array([[True, False], [True, True]]))

        path = tiff(np.ones((2, 2)), None, 0, 9, (5, 5), change=mask)
        with pytest.raises(ValueError, match=r"hills.tif: 1 of 4 heights are missing"):
            read(path)

    def test_what_is_no_geotiff(self, tmp_path):
        pytest.importorskip("rasterio")
        with pytest.raises(ValueError, match=r"hills.tif: not a GeoTIFF"):
            read(written(tmp_path, "hello", "hills.tif"))
