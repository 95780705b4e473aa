// The conversation with Python: one command in flight; of those that wait, the newest counts.

export class Connection {
  #socket = null;
  #nextId = 1;
  #inFlight = null;
  #waiting = new Map();  // by what they do

  // `listener` has state(message, mine), refused(message) and lost().
  constructor(listener) {
    this.listener = listener;
    this.#socket = new WebSocket(`ws://${location.host}/control`);
    this.#socket.onmessage = (event) => this.#receive(JSON.parse(event.data));
    this.#socket.onclose = () => this.#end();
  }

  get idle() {
    return this.#inFlight === null && this.#waiting.size === 0;
  }

  // Where the motors are being sent, if anywhere.
  get heading() {
    return this.#waiting.get("move")?.values ?? this.#inFlight?.values ?? null;
  }

  // Whether values wait that are newer than any answer.
  get moving() {
    return this.#waiting.has("move");
  }

  send(command) {
    if (this.#socket.readyState !== WebSocket.OPEN) return;
    this.#waiting.delete(command.command);  // the newest goes to the end
    this.#waiting.set(command.command, command);
    this.#pump();
  }

  #pump() {
    if (this.#inFlight !== null || this.#waiting.size === 0) return;
    const [[kind, command]] = this.#waiting;
    this.#waiting.delete(kind);
    this.#inFlight = { ...command, id: this.#nextId++ };
    this.#socket.send(JSON.stringify(this.#inFlight));
  }

  #receive(message) {
    const mine = message.id !== null && message.id === this.#inFlight?.id;
    if (mine) this.#inFlight = null;
    if (message.type === "error") this.listener.refused(message.message);
    else this.listener.state(message, mine);
    this.#pump();
    document.dispatchEvent(new CustomEvent("pmjac-update", { detail: message }));
  }

  #end() {
    this.#inFlight = null;
    this.#waiting.clear();
    this.listener.lost();
  }
}
