// Puts meshcat's camera where it sees all of a framing (framing.py), whatever the window's shape.
"use strict";

const MARGIN = 40;  // pixels on every side: for the labels, and to breathe

function fitView(viewer, framing, fullWidth, fullHeight) {
  const { centre, eye, extremes, field_of_view: angle } = framing;
  const slope = Math.tan((angle / 2) * (Math.PI / 180));
  const margin = Math.min(MARGIN, 0.1 * Math.min(fullWidth, fullHeight));
  const up = slope * Math.max(0.1, 1 - (2 * margin) / fullHeight);
  const across = (slope * Math.max(1, fullWidth - 2 * margin)) / fullHeight;
  const distance = Math.max(...extremes.map(([x, y, z]) => z + Math.max(x / across, y / up)));
  // In the camera's own axes y is up.
  const turned = ([x, y, z]) => [x, z, -y];
  const place = turned(centre.map((middle, k) => middle + distance * eye[k]));
  const camera = ["Cameras", "default", "rotated", "<object>"];
  const settings = { fov: angle, near: distance / 100, far: distance * 100, position: place };
  for (const [name, value] of Object.entries(settings)) viewer.set_property(camera, name, value);
  viewer.controls.target.set(...turned(centre));
  forgetPlaces(viewer);
  viewer.set_dirty();
}
