// Puts meshcat's camera where it sees all of a framing (framing.py), whatever the window's shape.
"use strict";

function fitView(viewer, framing, fullWidth, fullHeight) {
  const { centre, eye, width, height, depth } = framing;
  const aspect = fullWidth / Math.max(fullHeight, 1);
  const slope = Math.tan((framing.field_of_view / 2) * (Math.PI / 180));
  const distance = 1.06 * (Math.max(width / aspect, height) / slope + depth);
  // In the camera's own axes y is up.
  const turned = ([x, y, z]) => [x, z, -y];
  const place = turned(centre.map((middle, k) => middle + distance * eye[k]));
  const camera = ["Cameras", "default", "rotated", "<object>"];
  const settings = { fov: framing.field_of_view, near: distance / 100, far: distance * 100, position: place };
  for (const [name, value] of Object.entries(settings)) viewer.set_property(camera, name, value);
  viewer.controls.target.set(...turned(centre));
  viewer.set_dirty();
}
