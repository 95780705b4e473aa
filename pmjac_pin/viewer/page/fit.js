// Puts meshcat's camera where it sees all of a framing (framing.py), whatever the window's shape.
"use strict";

const MARGIN = 40;  // pixels on every side: for the labels, and to breathe

// In the camera's own axes y is up.
const turned = ([x, y, z]) => [x, z, -y];

// The share of a framing's outermost points that the camera sees, wherever it is now.
function shareInView({ camera }, { centre, eye, extremes }) {
  camera.updateMatrixWorld();
  const length = Math.hypot(eye[0], eye[1]);
  const right = [-eye[1] / length, eye[0] / length, 0];
  const up = [-eye[2] * right[1], eye[2] * right[0], length];
  const points = extremes.flatMap(([x, y, z]) => [[x, y, z], [-x, y, z], [x, -y, z], [-x, -y, z]]);
  const seen = points.filter(([x, y, z]) => {
    const place = centre.map((middle, k) => middle + x * right[k] + y * up[k] + z * eye[k]);
    const { x: across, y: high, z: depth } = camera.position.clone().set(...turned(place)).project(camera);
    return Math.max(Math.abs(across), Math.abs(high), Math.abs(depth)) <= 1;
  });
  return seen.length / points.length;
}

function fitView(viewer, framing, fullWidth, fullHeight) {
  const { centre, eye, extremes, field_of_view: angle } = framing;
  const slope = Math.tan((angle / 2) * (Math.PI / 180));
  const margin = Math.min(MARGIN, 0.1 * Math.min(fullWidth, fullHeight));
  const up = slope * Math.max(0.1, 1 - (2 * margin) / fullHeight);
  const across = (slope * Math.max(1, fullWidth - 2 * margin)) / fullHeight;
  const distance = Math.max(...extremes.map(([x, y, z]) => z + Math.max(x / across, y / up)));
  const place = turned(centre.map((middle, k) => middle + distance * eye[k]));
  const camera = ["Cameras", "default", "rotated", "<object>"];
  const settings = { fov: angle, near: distance / 100, far: distance * 100, position: place };
  for (const [name, value] of Object.entries(settings)) viewer.set_property(camera, name, value);
  viewer.controls.target.set(...turned(centre));
  forgetPlaces(viewer);
  viewer.set_dirty();
}
