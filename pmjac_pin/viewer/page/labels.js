// Writes the labels of the scene in letters of a readable size, each where it has room.
"use strict";

const LETTERS = { least: 13, most: 17 };  // pixels, whatever the distance
const GAP = 9;        // pixels between a label and the point that it belongs to
const CLEARANCE = 2;  // pixels between two labels
const DIRECTIONS = [[1, 1], [-1, 1], [1, -1], [-1, -1], [0, 1], [0, -1], [1, 0], [-1, 0]];
const RINGS = [1, 2, 3.2, 4.6, 6.5];

// Before every drawing, also that of a snapshot, the labels are placed anew.
function tidyLabels(viewer) {
  const render = viewer.render.bind(viewer);
  viewer.render = () => {
    viewer.controls.update();
    viewer.scene.updateMatrixWorld();
    viewer.camera.updateProjectionMatrix();
    placeLabels(viewer);
    render();
  };
}

// The same view shows the same picture, wherever the labels were before.
function forgetPlaces(viewer) {
  viewer.scene.traverse((object) => { delete object.userData.place; });
}

function placeLabels(viewer) {
  const { clientWidth: width, clientHeight: height } = viewer.renderer.domElement;
  const labels = [];
  viewer.scene.traverseVisible((object) => {
    if (object.isSprite && object.userData.text) labels.push(seen(object, viewer.camera, width, height));
  });
  const placed = [];
  for (const label of labels) {
    if (!label) continue;
    const rectangle = roomFor(label, placed, labels, width, height);
    placed.push(rectangle);
    shift(label, rectangle);
  }
}

// Where a label's point is in the window, how large its letters, and how large a pixel is there.
function seen(sprite, camera, width, height) {
  const point = sprite.position.clone().setFromMatrixPosition(sprite.matrixWorld);
  const depth = -point.clone().applyMatrix4(camera.matrixWorldInverse).z;
  const { x, y, z } = point.project(camera);
  if (z > 1 || depth <= 0) return null;
  const pixel = (2 * depth * Math.tan((camera.fov * Math.PI) / 360)) / (camera.zoom * height);
  const tall = sprite.parent.matrixWorld.getMaxScaleOnAxis();
  const size = Math.round(Math.min(LETTERS.most, Math.max(LETTERS.least, tall / pixel)));
  const { w, h } = write(sprite, size);
  sprite.scale.set((w * pixel) / tall, (h * pixel) / tall, 1);
  sprite.updateMatrixWorld();
  return { sprite, w, h, x: ((x + 1) / 2) * width, y: ((1 - y) / 2) * height };
}

// Draws the text into the sprite's texture, unless it is there already; returns its size.
function write(sprite, size) {
  const { text, colour, written } = sprite.userData;
  const ratio = Math.max(1, window.devicePixelRatio);
  const key = `${text} ${size} ${ratio}`;
  if (written?.key === key) return written;
  const texture = sprite.material.map;
  const canvas = texture.image;
  const context = canvas.getContext("2d");
  const font = `${size * ratio}px system-ui, -apple-system, "Segoe UI", Roboto, "Noto Sans", sans-serif`;
  context.font = font;
  canvas.width = Math.ceil(context.measureText(text).width) + Math.ceil(6 * ratio);
  canvas.height = Math.ceil(1.45 * size * ratio);
  Object.assign(context, { font, textAlign: "center", textBaseline: "middle", lineJoin: "round" });
  Object.assign(context, { lineWidth: 4 * ratio, strokeStyle: "rgba(255, 255, 255, 0.85)", fillStyle: colour });
  for (const draw of ["strokeText", "fillText"]) context[draw](text, canvas.width / 2, canvas.height / 2);
  texture.dispose();  // its size has changed
  Object.assign(texture, { minFilter: 1006, generateMipmaps: false, needsUpdate: true });  // THREE.LinearFilter
  sprite.userData.written = { key, w: canvas.width / ratio, h: canvas.height / ratio };
  return sprite.userData.written;
}

// The best of the places about its point: within the window, on no other label or labelled point.
function roomFor(label, placed, labels, width, height) {
  let best = null;
  for (const ring of RINGS) {
    for (const direction of DIRECTIONS) {
      const candidate = beside(label, direction, ring, width, height);
      const kept = label.sprite.userData.place === candidate.place ? 0 : 2;  // it does not hop about
      const cost = 8 * ring + kept + 20 * sum(placed, (other) => overlap(candidate, other))
        + 3 * sum(labels, (other) => (other ? overlap(candidate, around(other)) : 0));
      if (!best || cost < best.cost) best = { ...candidate, cost };
    }
  }
  label.sprite.userData.place = best.place;
  return best;
}

function beside({ x, y, w, h }, [right, up], ring, width, height) {
  const middle = [x + right * (w / 2 + GAP * ring), y - up * (h / 2 + (GAP - 4) * ring)];
  const left = Math.round(Math.min(width - w - 2, Math.max(2, middle[0] - w / 2)));
  const top = Math.round(Math.min(height - h - 2, Math.max(2, middle[1] - h / 2)));
  return { left, top, right: left + w, bottom: top + h, place: `${right} ${up} ${ring}` };
}

const around = ({ x, y }) => ({ left: x - 7, right: x + 7, top: y - 7, bottom: y + 7 });

const sum = (items, value) => items.reduce((total, item) => total + value(item), 0);

function overlap(one, other) {
  const across = Math.min(one.right, other.right) - Math.max(one.left, other.left) + CLEARANCE;
  const down = Math.min(one.bottom, other.bottom) - Math.max(one.top, other.top) + CLEARANCE;
  return across > 0 && down > 0 ? across * down : 0;
}

// A sprite's centre is the point of it, from 0 to 1, that lies on its position.
function shift({ sprite, x, y, w, h }, { left, top }) {
  sprite.center.set((x - left) / w, 1 - (y - top) / h);
  sprite.userData.rectangle = [left, top, w, h];
}
