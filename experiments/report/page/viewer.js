// The viewer: an image, another to flip or compare with, and a map of error, which zoom and pan as one.
//
//   keys     1 to 9 and 0 (the reference), or left and right: flip the image; + and -: zoom; f: fit; e and E: exposure;
//            with shift, arrows pan
//   pointer  wheel zooms, drag pans, drag with shift makes a crop of every image

const numberIn = (text, otherwise) => text !== undefined && text !== '' && isFinite(text) ? Number(text) : otherwise;

class Viewer {
  constructor(root, scene, index) {
    Object.assign(this, {root, scene, index, name: 'view' + index, pixels: new Map(), hover: null, tables: {}, crops: []});
    const notes = scene.notes.map(textContent => make('p', {className: 'note', textContent}));
    root.append(document.getElementById('viewer').content.cloneNode(true), ...notes);
    this.parts = Object.fromEntries(all('[data-part]', root).map(part => [part.dataset.part, part]));
    const {images} = scene;
    this.reference = images.findIndex(image => image.isReference);
    const known = images.map((image, i) => [image.error, i]).filter(([error]) => error !== null).sort((a, b) => a[0] - b[0]);
    this.left = known.length ? known[0][1] : images.length > 1 ? 1 : 0;
    this.right = 0;
    this.times = [...new Set(images.flatMap(image => image.frames.map(frame => frame.time)))].sort((a, b) => a - b);
    Object.assign(this, {ev: 0, tone: 'srgb', map: 'metric', frame: this.times.length});
    Object.assign(this, {zoom: 1, x: scene.width / 2, y: scene.height / 2});
    this.panes = ['left', 'right', 'map'].map(kind => new Pane(this, kind));
    this.restore();
    this.listen();
    this.fillSheet();
    this.update();
  }

  // --- what is shown ---
  get kind() { return this.map === 'metric' ? kindOfMetric(chosen.metric) : this.map; }
  get hasMaps() { return this.reference >= 0 && this.scene.images.length > 1; }
  // The frame of an image at the scrubber's time; undefined: its last image.
  frameOf(image) {
    if (this.frame >= this.times.length) return undefined;
    const past = image.frames.filter(frame => frame.time <= this.times[this.frame]);
    return image.frames.length ? past[past.length - 1] ?? image.frames[0] : undefined;
  }
  load(image, frame = this.frameOf(image)) {
    const source = frame ?? image;
    if (!this.pixels.has(source)) {
      const {width, height} = this.scene;
      const parts = [source.pixels, source.difference].map(part => part && decodeHalves(part, width, height));
      parts.push(source.flip && decodeHalves(source.flip, width, height, 1));
      this.pixels.set(source, Promise.all(parts).then(([x, difference, flip]) => ({x, difference, flip})));
    }
    return this.pixels.get(source);
  }
  get shown() { return this.scene.images[this.left]; }
  // The image whose error is mapped: the left one, else the right one; where both are the reference, the one before.
  chooseMapped() {
    const {images} = this.scene;
    this.mapped = [this.left, this.right, this.mapped].find(i => i !== undefined && i !== this.reference)
      ?? images.findIndex(image => !image.isReference);
  }
  table() {
    const key = this.tone + this.ev, {unit, white} = this.scene;
    if (this.tables.key !== key) this.tables = {key, bytes: toneTable(toneMaps[this.tone], unit / white * 2 ** this.ev)};
    return this.tables.bytes;
  }

  async update() {
    const {images} = this.scene, {parts} = this;
    this.chooseMapped();
    const controls = {left: this.left, right: this.right, tone: this.tone, kind: this.map, exposure: this.ev, time: this.frame};
    for (const [name, value] of Object.entries(controls)) parts[name].value = value;
    parts.ev.textContent = (this.ev > 0 ? '+' : '') + this.ev + ' EV';
    parts.at.textContent = this.frame < this.times.length ? figure3(this.times[this.frame]) + ' s' : 'end';
    const named = image => {  // the detail is of the last image
      const frame = this.frameOf(image), detail = frame ? 'after ' + figure3(frame.time) + ' s' : image.detail;
      return image.label + (detail ? ' (' + detail + ')' : '');
    };
    parts.leftName.textContent = named(this.shown);
    parts.rightName.textContent = named(images[this.right]);
    parts.exr.hidden = !this.shown.exr;
    if (this.shown.exr) parts.exr.href = this.shown.exr;
    parts.mapPane.hidden = !this.hasMaps;
    if (this.mapped >= 0) parts.mapName.textContent = mapKinds[this.kind].label + ' of ' + images[this.mapped].label;
    for (const button of all('.sheet button', this.root))
      button.setAttribute('aria-pressed', String(Number(button.value) === this.left));
    this.showScale();
    this.remember();
    const turn = this.turn = (this.turn ?? 0) + 1;  // what was asked for later is shown
    try {
      const wanted = [this.shown, images[this.right], images[this.reference], images[this.mapped]];
      const [left, right, reference, mapped] = await Promise.all(wanted.map(image => image && this.load(image)));
      if (turn !== this.turn) return;
      this.now = {left, right, reference, mapped};
      const {scene, kind} = this, table = this.table();
      for (const [i, pixels] of [left, right].entries())
        this.panes[i].show([pixels, table], canvas => paintImage(canvas, scene, pixels, table));
      this.draw();
      await new Promise(later => setTimeout(later));  // a map takes longer than a flip should
      if (turn !== this.turn) return;
      if (mapped && reference)
        this.panes[2].show([mapped, kind], canvas => paintMap(canvas, scene, images[this.mapped], mapped, reference, kind));
      parts.trouble.textContent = '';
      this.root.dataset.ready = 'true';
      this.draw();
      this.drawCrops();
    } catch (error) {
      parts.trouble.textContent = 'Not shown: ' + error.message + '.';
    }
  }
  draw() {
    for (const pane of this.panes) pane.draw();
    this.parts.zoom.textContent = '×' + figure3(this.panes[0].scale);
    this.readOut();
  }
  showScale() {
    const kind = mapKinds[this.kind], range = this.scene.ranges[this.kind];
    if (!range) return;
    this.parts.colourbar.style.background = 'linear-gradient(to right,' + (kind.signed ? diverging : viridis).stops.join(',') + ')';
    const ticks = [];
    if (kind.signed) ticks.push('≤ ' + figure3(range[0]), '0', '≥ ' + figure3(range[1]));
    else if (kind.even) ticks.push(...[0, 0.25, 0.5, 0.75, 1].map(t => figure3(range[0] + t * (range[1] - range[0]))));
    else for (let decade = range[0]; decade <= range[1]; ++decade)
      ticks.push((decade === range[0] ? '≤ ' : decade === range[1] ? '≥ ' : '') + '1e' + decade);
    this.parts.ticks.replaceChildren(...ticks.map(textContent => make('span', {textContent})));
  }

  // --- what lies under the pointer ---
  readOut() {
    const {scene, hover, now} = this;
    const lines = [];
    if (hover && now) {
      const pixel = hover.y * scene.width + hover.x, plane = scene.width * scene.height;
      const rgb = pixels => [0, 1, 2].map(c => figure3(valueAt(scene, pixels, pixel + c * plane))).join('  ');
      lines.push('pixel ' + hover.x + ', ' + hover.y, this.shown.label + ': ' + rgb(now.left));
      if (this.right !== this.left) lines.push(scene.images[this.right].label + ': ' + rgb(now.right));
      if (now.mapped && now.reference) {
        const error = name => figure3(errorAt(scene, scene.images[this.mapped], now.mapped, now.reference, mapKinds[name], pixel));
        const of = (this.mapped === this.left ? '' : ' of ' + scene.images[this.mapped].label) + ': ';
        lines.push('signed error' + of + error('signed'));
        if (this.kind !== 'signed') lines.push(mapKinds[this.kind].label + of + error(this.kind));
      }
    }
    if (!lines.length)
      lines.push('Point at a pixel for its values. Wheel: zoom, drag: pan, 1 to 9, 0 and arrows: flip, shift and drag: crop.');
    this.parts.values.replaceChildren(...lines.map(textContent => make('span', {textContent})));
  }

  // --- changes ---
  set(changes) {
    Object.assign(this, changes);
    this.ev = clamp(this.ev, -10, 10);
    return this.update();
  }
  flip(to) {
    const {length} = this.scene.images;
    return this.set({left: (to + length) % length});
  }
  // Keeps the point (x, y) of the image where it is in the pane.
  zoomBy(factor, x = this.x, y = this.y) {
    const {fit} = this.panes[0], most = Math.max(1, 64 / fit);
    const zoom = clamp(this.zoom * factor, 1, most), ratio = this.zoom / zoom;
    this.moveTo(x + (this.x - x) * ratio, y + (this.y - y) * ratio, zoom);
  }
  moveTo(x, y, zoom = this.zoom) {
    const {width, height} = this.scene, half = 0.5 / zoom;
    Object.assign(this, {zoom, x: clamp(x, width * half, width * (1 - half)), y: clamp(y, height * half, height * (1 - half))});
    for (const pane of this.panes) pane.canvas.style.touchAction = zoom > 1 ? 'none' : 'pan-y';
    this.remember();
    this.draw();
  }

  listen() {
    const {parts, scene} = this;
    const fill = (select, options) => { for (const [value, label] of options) select.add(new Option(label, value)); };
    for (const side of ['left', 'right']) fill(parts[side], scene.images.map((image, i) => [i, image.label]));
    fill(parts.tone, Object.entries(toneMaps).map(([name, {label}]) => [name, label]));
    const kinds = Object.entries(mapKinds).filter(([name]) => name in scene.ranges);
    fill(parts.kind, [['metric', 'of the metric'], ...kinds.map(([name, {label}]) => [name, label])]);
    parts.kind.closest('label').hidden = !this.hasMaps;
    parts.time.closest('label').hidden = this.times.length < 2;
    parts.time.max = this.times.length;
    parts.left.addEventListener('change', () => this.set({left: Number(parts.left.value)}));
    parts.right.addEventListener('change', () => this.set({right: Number(parts.right.value)}));
    parts.tone.addEventListener('change', () => this.set({tone: parts.tone.value}));
    parts.kind.addEventListener('change', () => this.set({map: parts.kind.value}));
    parts.exposure.addEventListener('input', () => this.set({ev: Number(parts.exposure.value)}));
    parts.time.addEventListener('input', () => this.set({frame: Number(parts.time.value)}));
    parts.closer.addEventListener('click', () => this.zoomBy(2));
    parts.farther.addEventListener('click', () => this.zoomBy(0.5));
    parts.fit.addEventListener('click', () => this.moveTo(0, 0, 1));
    onChoice.push(() => { this.update(); this.paintSheet(); });
    new ResizeObserver(() => { for (const pane of this.panes) pane.resize(); this.draw(); }).observe(parts.panes);
  }
  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return false;
    const step = 0.1 / this.zoom, {width, height} = this.scene;
    const pans = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[event.key];
    if (/^[0-9]$/.test(event.key)) {
      const others = this.scene.images.map((_, i) => i).filter(i => i !== this.reference);
      const to = event.key === '0' ? this.reference : others[Number(event.key) - 1];
      if (to === undefined || to < 0) return false;
      this.set({left: to});
    } else if (pans && event.shiftKey) this.moveTo(this.x + pans[0] * step * width, this.y + pans[1] * step * height);
    else if (event.key === 'ArrowLeft' || event.key === 'ArrowRight') this.flip(this.left + pans[0]);
    else if (event.key === '+' || event.key === '=') this.zoomBy(1.5);
    else if (event.key === '-') this.zoomBy(1 / 1.5);
    else if (event.key === 'f') this.moveTo(0, 0, 1);
    else if (event.key === 'e' || event.key === 'E') this.set({ev: this.ev + (event.key === 'e' ? 0.5 : -0.5)});
    else return false;
    return true;
  }

  // --- the sheet: every image with its map ---
  fillSheet() {
    const {images} = this.scene;
    this.parts.compared.hidden = images.length < 3 || !this.hasMaps;
    images.forEach((image, value) => {
      const {src} = document.querySelector('a[data-scene="' + this.index + '"][data-image="' + value + '"] img');
      const button = make('button', {type: 'button', value}, make('img', {src, alt: ''}));
      if (this.hasMaps && value !== this.reference) button.append(make('canvas', {className: 'small-map'}));
      button.append(make('span', {textContent: image.label}));
      if (image.error !== null) button.append(make('span', {className: 'note', textContent: 'relmse ' + figure3(image.error)}));
      button.addEventListener('click', () => this.set({left: value}));
      this.parts.sheet.append(button);
    });
    this.paintSheet();
  }
  // Shows images that the page itself holds; others would be read from disk for a thumbnail.
  async paintSheet() {
    const {images} = this.scene;
    if (!this.hasMaps) return;
    const kind = this.kind, buttons = all('.sheet button', this.root);
    for (const [i, image] of images.entries()) {
      const canvas = buttons[i].querySelector('canvas');
      if (!canvas || image.pixels.data === undefined || images[this.reference].pixels.data === undefined) {
        canvas?.remove();
        continue;
      }
      const [pixels, reference] = await Promise.all([this.load(image, null), this.load(images[this.reference], null)]);
      if (kind !== this.kind) return;
      paintMap(canvas, this.scene, image, pixels, reference, kind);
    }
  }

  // --- the view in the address ---
  remember() {
    if (!this.restored) return;
    const entries = Object.entries(this.initial).filter(([name, value]) => value !== this[name]).map(([name]) => [name, this[name]]);
    if (this.zoom > 1) entries.push(['zoom', this.zoom.toFixed(3)], ['x', this.x.toFixed(1)], ['y', this.y.toFixed(1)]);
    for (const crop of this.crops) entries.push(['crop', crop.join('-')]);
    view.write({[this.name]: entries.length ? entries.map(entry => entry.join(':')).join(',') : null});
  }
  restore() {
    const {left, right, ev, tone, map, frame} = this;
    this.initial = {left, right, ev, tone, map, frame};
    const entries = (view.parameters.get(this.name) ?? '').split(',').map(entry => entry.split(':'));
    const {images, width, height} = this.scene, given = Object.fromEntries(entries);
    const index = (name, most) => clamp(Math.round(numberIn(given[name], this[name])), 0, most);
    for (const [name, most] of [['left', images.length - 1], ['right', images.length - 1], ['frame', this.times.length]])
      this[name] = index(name, most);
    this.ev = clamp(numberIn(given.ev, 0), -10, 10);
    if (given.tone in toneMaps) this.tone = given.tone;
    if (given.map in this.scene.ranges) this.map = given.map;
    this.zoom = clamp(numberIn(given.zoom, 1), 1, 1e4);
    this.x = clamp(numberIn(given.x, this.x), 0, width);
    this.y = clamp(numberIn(given.y, this.y), 0, height);
    for (const [name, value] of entries)
      if (name === 'crop') this.addCrop(value.split('-').map(Number));
    this.restored = true;
  }
}
