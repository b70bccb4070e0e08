// The one websocket: opened again whenever it is lost, then told everything anew.

const SILENCE_MS = 4000; // the server speaks five times a second
const LONGEST_WAIT_MS = 4000;

export class Link {
  constructor(onMessage, onCells, onState) {
    Object.assign(this, { onMessage, onCells, onState });
    this.wait = 250;
    this.asks = 0;
    this.open();
    setInterval(() => this.check(), 1000);
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    const socket = new WebSocket(`${scheme}://${location.host}/feed`);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    this.heard = performance.now();
    socket.onopen = () => {
      this.wait = 250;
      this.heard = performance.now();
      this.onState(true);
    };
    socket.onmessage = (event) => {
      this.heard = performance.now();
      if (typeof event.data === "string") this.onMessage(JSON.parse(event.data));
      else this.onCells(event.data);
    };
    socket.onclose = () => this.lost(socket);
  }

  lost(socket) {
    if (socket !== this.socket) return;
    this.socket = null;
    this.onState(false);
    setTimeout(() => this.open(), this.wait);
    this.wait = Math.min(this.wait * 2, LONGEST_WAIT_MS);
  }

  check() {
    const socket = this.socket;
    if (!socket || performance.now() - this.heard < SILENCE_MS) return;
    socket.close();
    this.lost(socket); // its own close event may take long
  }

  // Returns the number of the ask, 0 when there is nobody to ask.
  ask(wish) {
    if (!this.socket || this.socket.readyState !== WebSocket.OPEN) return 0;
    this.asks += 1;
    this.socket.send(JSON.stringify({ ...wish, ask: this.asks }));
    return this.asks;
  }
}
