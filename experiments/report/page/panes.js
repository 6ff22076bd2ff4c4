// A pane of the viewer shows one of its pictures, and its crops show a piece of each.

class Pane {
  constructor(viewer, kind) {
    this.viewer = viewer;
    this.canvas = viewer.parts[kind + 'Canvas'];
    this.pixels = document.createElement('canvas');  // at the image's own size
    this.resize();
    for (const type of ['pointerdown', 'pointermove', 'pointerup', 'pointerleave', 'pointercancel'])
      this.canvas.addEventListener(type, event => this[type](event));
    this.canvas.addEventListener('wheel', event => {
      event.preventDefault();
      const at = this.imagePoint(event), lines = event.deltaMode === 1 ? 30 : 1;
      viewer.zoomBy(Math.exp(-0.002 * lines * event.deltaY), at.x, at.y);
    }, {passive: false});
    this.canvas.addEventListener('keydown', event => { if (viewer.key(event)) event.preventDefault(); });
    this.canvas.addEventListener('dblclick', () => viewer.moveTo(0, 0, 1));
  }

  // Paints what the pane shows, unless it is painted already from the same.
  show(from, paint) {
    if (this.from && from.every((part, i) => part === this.from[i])) return;
    this.from = from;
    paint(this.pixels);
  }
  resize() {
    const {width, height} = this.viewer.scene, across = this.canvas.clientWidth || 300;
    this.ratio = Math.min(devicePixelRatio || 1, 2);
    this.across = across;
    this.down = Math.round(across * height / width);
    this.canvas.style.height = this.down + 'px';
    this.canvas.width = Math.round(across * this.ratio);
    this.canvas.height = Math.round(this.down * this.ratio);
  }
  get fit() { return this.across / this.viewer.scene.width; }  // screen pixels for one of the image, all of it shown
  get scale() { return this.fit * this.viewer.zoom; }

  draw() {
    const {viewer, ratio, scale} = this, context = this.canvas.getContext('2d');
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    if (!this.pixels.width) return;
    const left = this.across / 2 - viewer.x * scale, top = this.down / 2 - viewer.y * scale;
    context.setTransform(scale * ratio, 0, 0, scale * ratio, ratio * left, ratio * top);
    context.imageSmoothingEnabled = scale * ratio < 1;
    context.imageSmoothingQuality = 'high';
    context.drawImage(this.pixels, 0, 0);
    const outline = (x, y, width, height, colour) => {
      context.lineWidth = 3 / scale;
      context.strokeStyle = '#000a';
      context.strokeRect(x, y, width, height);
      context.lineWidth = 1.5 / scale;
      context.strokeStyle = colour;
      context.strokeRect(x, y, width, height);
    };
    for (const [i, crop] of viewer.crops.entries()) outline(...crop, cropColours[i % cropColours.length]);
    if (this.drawn) outline(...this.drawn, '#fff');
    if (viewer.hover && scale >= 2) outline(viewer.hover.x, viewer.hover.y, 1, 1, '#fff');
  }

  imagePoint(event) {
    const {left, top, width, height} = this.canvas.getBoundingClientRect(), {viewer, scale} = this;
    return {x: viewer.x + (event.clientX - left - width / 2) / scale, y: viewer.y + (event.clientY - top - height / 2) / scale};
  }
  pointerdown(event) {
    this.canvas.focus({preventScroll: true});
    this.canvas.setPointerCapture(event.pointerId);
    this.held = {at: this.imagePoint(event), crops: event.shiftKey};
    this.pointermove(event);  // a finger does not hover
  }
  pointermove(event) {
    const {viewer} = this, {width, height} = viewer.scene, at = this.imagePoint(event);
    if (this.held && this.held.crops) {
      const ends = [[this.held.at.x, at.x, width], [this.held.at.y, at.y, height]].map(([from, to, most]) => [
        clamp(Math.floor(Math.min(from, to)), 0, most - 1), clamp(Math.ceil(Math.max(from, to)), 1, most)]);
      this.drawn = [ends[0][0], ends[1][0], ends[0][1] - ends[0][0], ends[1][1] - ends[1][0]];
    } else if (this.held && viewer.zoom > 1) {
      viewer.moveTo(viewer.x + this.held.at.x - at.x, viewer.y + this.held.at.y - at.y);
    }
    const inside = at.x >= 0 && at.y >= 0 && at.x < width && at.y < height;
    viewer.hover = inside ? {x: Math.floor(at.x), y: Math.floor(at.y)} : null;
    viewer.draw();
  }
  pointerup() {
    const {drawn, viewer} = this;
    this.held = this.drawn = null;
    if (!drawn || drawn[2] < 2 || drawn[3] < 2) return;
    viewer.addCrop(drawn);
    viewer.remember();
    viewer.draw();
    viewer.drawCrops();
  }
  pointercancel() { this.held = this.drawn = null; }
  pointerleave() {
    this.viewer.hover = null;
    this.viewer.draw();
  }
}

// --- crops: a piece of every image, and of its map below ---
const cropColours = ['#e69f00', '#56b4e9', '#f0e442', '#cc79a7'], mostCrops = 4;
Object.assign(Viewer.prototype, {
  addCrop(crop) {
    const {width, height} = this.scene;
    const [x, y] = [clamp(crop[0], 0, width - 1), clamp(crop[1], 0, height - 1)];
    const piece = [x, y, clamp(crop[2], 1, width - x), clamp(crop[3], 1, height - y)];
    if (crop.length === 4 && piece.every(Number.isInteger)) this.crops = [...this.crops, piece].slice(-mostCrops);
  },
  removeCrop(index) {
    this.crops.splice(index, 1);
    this.remember();
    this.draw();
    this.drawCrops();
  },
  async drawCrops() {
    const {images} = this.scene, {parts, crops} = this, turn = this.cropTurn = (this.cropTurn ?? 0) + 1;
    parts.crops.hidden = !crops.length;
    if (!crops.length) return parts.crops.replaceChildren();
    const rows = crops.map((crop, index) => {
      const remove = make('button', {type: 'button', textContent: 'remove'});
      remove.addEventListener('click', () => this.removeCrop(index));
      const row = make('div', {className: 'crop-row'});
      row.style.setProperty('--crop', cropColours[index % cropColours.length]);
      const [x, y, width, height] = crop;
      row.append(make('p', {className: 'note'}, 'Crop at ' + x + ', ' + y + ', ' + width + ' × ' + height + ' pixels ', remove));
      return row;
    });
    const whole = document.createElement('canvas');
    for (const image of images) {
      const reference = this.hasMaps ? await this.load(images[this.reference], null) : null, pixels = await this.load(image);
      if (turn !== this.cropTurn) return;
      const pieces = crops.map(() => make('figure', {}, make('figcaption', {textContent: image.label})));
      const cut = () => crops.forEach(([x, y, width, height], i) => {
        const piece = make('canvas', {width, height});
        piece.getContext('2d').drawImage(whole, -x, -y);
        pieces[i].lastChild.before(piece);
      });
      paintImage(whole, this.scene, pixels, this.table());
      cut();
      if (reference && !image.isReference) {
        paintMap(whole, this.scene, image, pixels, reference, this.kind);
        cut();
      }
      pieces.forEach((piece, i) => rows[i].append(piece));
    }
    parts.crops.replaceChildren(...rows);
  }
});
