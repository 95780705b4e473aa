// The conversation with Python: one command in flight; of those that wait, the newest counts.

const RETRY = { first: 500, most: 5000 };  // milliseconds

export class Connection {
  #socket = null;
  #nextId = 1;
  #inFlight = null;
  #waiting = new Map();  // by what they do

  #delay = RETRY.first;

  // `listener` has state(message, mine), refused(message), lost(), and `told`, with a function for
  // each type of message that answers no command.
  constructor(listener) {
    this.listener = listener;
    this.#open();
  }

  #open() {
    this.#socket = new WebSocket(`ws://${location.host}/control`);
    this.#socket.onopen = () => { this.#delay = RETRY.first; };
    this.#socket.onmessage = (event) => this.#receive(JSON.parse(event.data));
    this.#socket.onclose = () => this.#end();
  }

  get idle() {
    return this.#inFlight === null && this.#waiting.size === 0;
  }

  // Where the motors are being sent: null for those that are where they were last told to be.
  get heading() {
    return this.#sent("move");
  }

  // What the parameters are being set to.
  get setting() {
    return this.#sent("set");
  }

  // The parameter of the trajectory that waits, in a list.
  get replaying() {
    return this.#waiting.get("moment")?.values ?? null;
  }

  // Those that wait, newer than any answer.
  get moving() {
    return this.#waiting.get("move")?.values ?? null;
  }

  #sent(kind) {
    const inFlight = this.#inFlight?.command === kind ? this.#inFlight.values : null;
    return merged(inFlight, this.#waiting.get(kind)?.values);
  }

  send(command) {
    if (this.#socket.readyState !== WebSocket.OPEN) return;
    const { command: kind, values } = command;
    const older = this.#waiting.get(kind)?.values;
    this.#waiting.delete(kind);  // the newest goes to the end
    this.#waiting.set(kind, values ? { ...command, values: merged(older, values) } : command);
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
    if (message.type in this.listener.told) {
      this.listener.told[message.type](message);
      return;
    }
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
    setTimeout(() => this.#open(), this.#delay);
    this.#delay = Math.min(2 * this.#delay, RETRY.most);
  }
}

// Of two lists of motor values the newer ones, where there are any.
function merged(older, newer) {
  if (!older || !newer) return newer ?? older ?? null;
  return newer.map((value, index) => value ?? older[index]);
}
