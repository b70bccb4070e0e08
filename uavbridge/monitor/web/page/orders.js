// Order buttons: to all agents or to one, with a question before the dangerous ones.

const BUTTONS = {
  pause: ["Pause", "stand still in the air"],
  resume: ["Resume", "search on"],
  goto: ["Go to …", "then click on a map: fly there and stand still"],
  hold: ["Hold", "the autopilot's own hold; the agent lets go of the vehicle"],
  takeover: ["Take over", "take back a vehicle that was held or that somebody took"],
  rtl: ["Return", "fly home and land"],
  land: ["Land", "land here"],
  abort: ["Abort", "everybody lands, the mission ends"],
};
const QUESTIONS = {
  hold: "Let the autopilots hold",
  rtl: "End the search and call home",
  land: "Land, right where they are,",
  abort: "Abort the mission and land, right where they are,",
};

export class Orders {
  constructor(link, state) {
    Object.assign(this, { link, state });
    this.bar = document.querySelector("#orders");
    this.to = document.querySelector("#order-to");
    this.result = document.querySelector("#order-result");
    this.dialog = document.querySelector("#confirm");
    this.waiting = new Set();
    this.aiming = false;
    this.names = "";
  }

  draw() {
    const orders = this.state.mission ? this.state.mission.orders : [];
    const names = orders.join(" ");
    this.bar.hidden = !orders.length;
    if (names !== this.names) {
      this.names = names;
      const buttons = orders.filter((name) => BUTTONS[name]).map((name) => this.button(name));
      document.querySelector("#order-buttons").replaceChildren(...buttons);
    }
    offer(this.to, [...this.state.rows.keys()].sort((a, b) => a - b));
  }

  button(name) {
    const button = document.createElement("button");
    [button.textContent, button.title] = BUTTONS[name];
    button.dataset.order = name;
    if (QUESTIONS[name]) button.className = "danger";
    button.addEventListener("click", () => (name === "goto" ? this.aim(!this.aiming) : this.give(name)));
    return button;
  }

  aim(on) {
    this.aiming = on;
    document.querySelector("[data-order=goto]")?.classList.toggle("armed", on);
    for (const canvas of document.querySelectorAll(".picture canvas")) canvas.classList.toggle("aiming", on);
  }

  // A click on a map while aiming; returns whether it was meant for us.
  placed(x, y) {
    if (!this.aiming) return false;
    this.aim(false);
    this.give("goto", [x, y]);
    return true;
  }

  async give(name, to = null) {
    const agent = this.to.value === "" ? null : Number(this.to.value);
    const whom = agent === null ? `all ${this.state.rows.size} agents` : `agent ${agent}`;
    const question = QUESTIONS[name] ?? (to && agent === null ? "Send to one point" : null);
    if (question && !(await this.sure(`${question} ${whom}?`, BUTTONS[name][0]))) {
      this.say(`${BUTTONS[name][0]}: not sent`, false);
      return;
    }
    const ask = this.link.ask({ order: name, agent, to });
    if (!ask) {
      this.say(`${BUTTONS[name][0]}: not sent, the connection is lost`, true);
      return;
    }
    this.waiting.add(ask);
    this.say(`${BUTTONS[name][0]} to ${whom} …`, false);
  }

  sure(text, word) {
    document.querySelector("#confirm-text").textContent = text;
    document.querySelector("#confirm-yes").textContent = word;
    this.dialog.returnValue = "no";
    this.dialog.showModal();
    return new Promise((resolve) => {
      this.dialog.addEventListener("close", () => resolve(this.dialog.returnValue === "yes"), { once: true });
    });
  }

  answered(answer) {
    if (!this.waiting.delete(answer.ask)) return;
    const name = BUTTONS[answer.verb]?.[0] ?? answer.verb;
    const whole = answer.done.length + answer.refused.length;
    const refusals = answer.refused.slice(0, 3).map(([id, why]) => `agent ${id}: ${why}`);
    if (answer.refused.length > 3) refusals.push("…");
    const text = answer.fault || `${answer.done.length} of ${whole} in ${answer.took_s.toFixed(2)} s`;
    this.say([`${name}: ${text}`, ...refusals].join("; "), Boolean(answer.fault || refusals.length));
  }

  lost() {
    if (this.waiting.size) this.say("the connection was lost before an answer came", true);
    this.waiting.clear();
  }

  say(text, bad) {
    this.result.textContent = text;
    this.result.classList.toggle("bad", bad);
  }
}

// Keeps the agents of a select up to date, and what is chosen in it.
export function offer(select, ids) {
  const known = [...select.options].slice(1).map((option) => Number(option.value));
  if (known.length === ids.length && known.every((id, i) => id === ids[i])) return;
  const chosen = select.value;
  while (select.options.length > 1) select.remove(1);
  for (const id of ids) select.add(new Option(`agent ${id}`, String(id)));
  select.value = ids.includes(Number(chosen)) ? chosen : select.options[0].value;
}
