// meshcat's viewer in its pane: framed, labelled, and turned without a pointer too.
"use strict";

const TURN = Math.PI / 36;  // of an arrow key
const ZOOM = 1.15;          // of + and -
const TURNS = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
const ZOOMS = { "+": 1 / ZOOM, "=": 1 / ZOOM, "-": ZOOM, "_": ZOOM };
const NO_WEBGL = "This browser cannot draw in three dimensions (no WebGL). All else works.";

class Stage {
  constructor(pane) {
    this.viewer = new MeshCat.Viewer(pane);
    this.viewer.gui.domElement.style.display = "none";
    this.framing = null;
    this.touched = false;  // whether the user has turned it
    tidyLabels(this.viewer);
    pane.addEventListener("keydown", (event) => this.press(event));
    for (const kind of ["pointerdown", "wheel"]) {
      pane.addEventListener(kind, () => { this.touched = true; }, { passive: true });
    }
    window.addEventListener("resize", () => { if (!this.touched) this.fit(); });
  }

  // What is shown fits in here; the view follows unless the user has turned it.
  frameOn(framing) {
    this.framing = framing;
    if (!this.touched) this.fit();
  }

  // The view stays where it is as long as it shows what there is, or most of it once it is turned.
  keepInView(framing) {
    this.framing = framing;
    const seen = shareInView(this.viewer, framing);
    if (seen < (this.touched ? 0.5 : 1)) this.reset();
  }

  reset() {
    this.touched = false;
    this.fit();
  }

  fit() {
    if (this.framing) fitView(this.viewer, this.framing, window.innerWidth, window.innerHeight);
  }

  // A PNG of this width, as a data URL.
  capture(width) {
    const { renderer } = this.viewer;
    const usual = renderer.getPixelRatio();
    renderer.setPixelRatio(width / window.innerWidth);
    try {
      return this.viewer.capture_image();
    } finally {
      renderer.setPixelRatio(usual);
      this.viewer.set_dirty();
    }
  }

  press(event) {
    if (event.altKey || event.ctrlKey || event.metaKey) return;
    const turn = TURNS[event.key];
    if (turn) this.move(...turn.map((way) => way * TURN * (event.shiftKey ? 0.2 : 1)), 1);
    else if (ZOOMS[event.key]) this.move(0, 0, ZOOMS[event.key]);
    else return;
    event.preventDefault();
  }

  // Turns the camera about what it looks at; in its own axes y is up.
  move(around, over, distance) {
    const { camera, controls } = this.viewer;
    const offset = camera.position.clone().sub(controls.target);
    const length = offset.length();
    const azimuth = Math.atan2(offset.x, offset.z) + around;
    const height = Math.min(1.55, Math.max(-1.55, Math.asin(offset.y / length) + over));
    offset.set(Math.cos(height) * Math.sin(azimuth), Math.sin(height), Math.cos(height) * Math.cos(azimuth));
    camera.position.copy(controls.target).addScaledVector(offset, length * distance);
    this.touched = true;
    this.viewer.set_dirty();
  }
}

// The stage of a pane; none, and words instead, where the browser cannot draw.
function makeStage(pane) {
  try {
    return new Stage(pane);
  } catch (error) {
    console.info(error);
    pane.removeAttribute("tabindex");
    pane.replaceChildren(Object.assign(document.createElement("p"), { textContent: NO_WEBGL }));
    return null;
  }
}
