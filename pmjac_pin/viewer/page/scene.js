// meshcat's viewer, fed by our own server: one message may hold an array of commands.
"use strict";

var viewer = new MeshCat.Viewer(document.getElementById("pane"));
viewer.gui.domElement.style.display = "none";
tidyLabels(viewer);
const handleOne = viewer.handle_command.bind(viewer);
viewer.handle_command = (command) => {
  if (Array.isArray(command)) command.forEach(handleOne);
  else handleOne(command);
};
viewer.connect(`ws://${location.host}/scene`);
viewer.connection.onclose = null;
