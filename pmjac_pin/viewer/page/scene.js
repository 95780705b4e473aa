// The stage, fed by our own server: one message may hold an array of commands.
"use strict";

const RETRY = { first: 500, most: 5000 };  // milliseconds

var stage = makeStage(document.getElementById("pane"));
var viewer = stage?.viewer ?? null;

function connect(delay) {
  viewer.connect(`ws://${location.host}/scene`);
  const fresh = viewer.connection;
  let wait = delay;
  fresh.onopen = () => {
    // The whole picture comes now, perhaps of another mechanism.
    viewer.handle_command({ type: "delete", path: "/pmjac" });
    wait = RETRY.first;
  };
  fresh.onclose = () => setTimeout(() => connect(Math.min(2 * wait, RETRY.most)), wait);
}

if (viewer) {
  const handleOne = viewer.handle_command.bind(viewer);
  viewer.handle_command = (command) => {
    if (Array.isArray(command)) command.forEach(handleOne);
    else handleOne(command);
  };
  connect(RETRY.first);
}
