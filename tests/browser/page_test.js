// The page in a browser: runs a hundred cells, opens their report.html in headless Chromium and does what a reader does.
//
//   node page_test.js ETENDUE CHROMIUM DIRECTORY
//
// Exits with 77 where puppeteer-core is not installed (npm install puppeteer-core, or NODE_PATH), 1 where a check fails.
'use strict';
const assert = require('assert');
const {execFileSync} = require('child_process');
const fs = require('fs');
const path = require('path');
const {readExr} = require('./exr.js');

let puppeteer;
try {
  puppeteer = require('puppeteer-core');
} catch {
  console.log('puppeteer-core is not installed; the page is not tried in a browser');
  process.exit(77);
}

const [etendue, chromium, directory] = process.argv.slice(2);
const mostBytes = 20e6, mostMilliseconds = 2000;
const state = page => page.evaluate(() => { const {left, right, zoom, x, y, kind, ev} = viewers.get(0); return {left, right, zoom, x, y, kind, ev}; });
const ready = () => document.body.dataset.ready && all('.viewer').every(viewer => viewer.dataset.ready);
const settled = page => page.evaluate(() => new Promise(done => setTimeout(done, 300)));
const shown = (page, selector) => page.$eval(selector, element => element.textContent);

const checks = {
  async 'it loads at once and is small'(page, {file, url}) {
    assert(fs.statSync(file).size <= mostBytes, 'the page is ' + fs.statSync(file).size + ' bytes');
    let best = Infinity;  // of three: the machine may be busy
    for (let i = 0; i < 3 && best > mostMilliseconds; ++i) {
      await page.goto(url);
      await page.waitForFunction(ready);
      best = Math.min(best, await page.evaluate(() => Number(document.body.dataset.ready)));
    }
    console.log('  ' + fs.statSync(file).size + ' bytes, interactive after ' + best + ' ms');
    assert(best <= mostMilliseconds, 'interactive after ' + best + ' ms');
  },

  async 'legends switch and isolate series'(page) {
    const button = 'figure.main ul.legend li:first-child button';
    const hiddenKeys = () => page.evaluate(() => [...new Set(all('.series.hidden').map(s => s.dataset.key))].length);
    const count = (await (await page.$('figure.main')).$$('ul.legend button')).length;
    await page.click(button);
    assert.equal(await hiddenKeys(), 1);
    await page.click(button);
    assert.equal(await hiddenKeys(), 0);
    await settled(page);
    await settled(page);
    await page.click(button, {count: 2});
    assert.equal(await hiddenKeys(), count - 1, 'a double click shows one alone');
    await settled(page);
    await settled(page);
    await page.click(button, {count: 2});
    assert.equal(await hiddenKeys(), 0, 'a second one shows all');
    await page.hover(button);
    assert(await page.evaluate(() => document.querySelectorAll('.series.hot').length > 0));
    assert.equal(await page.evaluate(() => document.querySelectorAll('figure.main .multiple').length > 0), true);
  },

  async 'what is switched off is off in small multiples, and has none'(page) {
    const button = 'figure.main ul.legend li:first-child button';
    const drawn = () => page.evaluate(key => {
      const places = all('figure.main').find(figure => figure.querySelector('.multiple')).querySelectorAll('.multiple');
      const visible = [...places].filter(place => place.offsetHeight > 0);
      const isDrawn = part => getComputedStyle(part).display !== 'none';
      return {panels: visible.length, parts: visible.flatMap(place => all('g[data-key=' + key + ']', place)).filter(isDrawn).length};
    }, key);
    const key = await page.$eval(button, element => element.dataset.key), before = await drawn();
    assert(before.parts === before.panels, JSON.stringify(before));
    await page.click(button);
    assert.deepEqual(await drawn(), {panels: before.panels - 1, parts: 0});
    await settled(page);
    await settled(page);
    await page.click(button);
    assert.deepEqual(await drawn(), before);
  },

  async 'linear small multiples keep their ticks'(page) {
    await page.click('.toolbar [name=scale][value=linear]');
    const ticks = await page.evaluate(() => all('text[text-anchor=middle]', document.querySelector('.multiple svg')).map(t => t.textContent));
    const whole = await page.evaluate(() => all('.stage svg .axes > text[text-anchor=middle]:not(.axis-title)', document.querySelector('figure.main')).map(t => t.textContent));
    assert.deepEqual(ticks, whole.slice(Number(whole[0]) === 0 ? 1 : 0));
    await page.click('.toolbar [name=scale][value=log]');
  },

  async 'links lead to headings in sight, and keep the view'(page) {
    await page.setViewport({width: 760, height: 700});
    await page.select('.toolbar select', 'mse');
    await settled(page);
    await page.click('nav a[href="#tables"]');
    await settled(page);
    const {heading, covered} = await page.evaluate(() => ({
      heading: document.querySelector('#tables h2').getBoundingClientRect().top, covered: toolbar.getBoundingClientRect().bottom}));
    assert(heading >= covered - 1 && heading < covered + 40, heading + ' beneath ' + covered);
    assert(await page.evaluate(() => location.hash.includes('metric=mse')), 'the address loses the view');
    await page.select('.toolbar select', 'relmse');
    await page.setViewport({width: 1280, height: 900});
    await settled(page);
  },

  async 'one colour and mark a method everywhere'(page) {
    const looks = await page.evaluate(() => all('figure.main .stage .series[data-key^=i]').filter(s => !s.matches('.stairs')).map(s =>
      [s.dataset.key, [...s.classList].filter(c => /^c\d$/.test(c)).join()]));
    const colours = new Map();
    for (const [key, colour] of looks) {
      if (!colours.has(key)) colours.set(key, colour);
      assert.equal(colour, colours.get(key), key);
    }
  },

  async 'a read-out keeps whole counts, names and units'(page) {
    const svg = 'figure.main .stage svg.chart';
    const told = async (title, points) => {
      await page.$eval(svg, (svg, title, points) => {
        svg.dataset.x = title;
        svg.querySelector('.series[data-p]:not(.stairs)').dataset.p = points;
        parsed.delete(svg);
        delete svg.dataset.at;
      }, title, points);
      await page.$eval(svg, svg => svg.focus());
      await page.keyboard.press('ArrowRight');
      return shown(page, 'figure.main .tip');
    };
    assert((await told('iterations', '9,9,2048,0.5;9,9,4096,0.5')).includes('iterations 4096'));
    assert((await told('radius of the ball [m], harm grows to the left', '9,9,1,0.5;9,9,0.2236,0.5')).includes('radius of the ball 0.224 m'));
    await page.keyboard.press('Escape');
    for (const axis of ['iterations', 'time']) await page.click('.toolbar [name=axis][value=' + axis + ']');  // as it was
  },

  async 'keys flip images'(page) {
    await page.focus('.viewer canvas');
    await page.keyboard.press('2');
    await settled(page);
    assert.equal(await shown(page, '.viewer [data-part=leftName]').then(t => t.split(' ')[0]), 'light-trace');
    await page.keyboard.press('0');
    await settled(page);
    assert((await shown(page, '.viewer [data-part=leftName]')).startsWith('reference'));
    await page.keyboard.press('ArrowRight');
    await settled(page);
    assert((await shown(page, '.viewer [data-part=leftName]')).startsWith('path'));
  },

  async 'panes zoom as one, and the page stays'(page) {
    await page.$eval('.viewer canvas', canvas => canvas.scrollIntoView({block: 'center'}));
    const before = await page.evaluate(() => scrollY), canvas = await page.$('.viewer canvas'), box = await canvas.boundingBox();
    await page.mouse.move(box.x + box.width * 0.25, box.y + box.height * 0.25);
    await page.mouse.wheel({deltaY: -700});
    await settled(page);
    const {zoom, x} = await state(page);
    assert(zoom > 2 && x < 24, 'zoom ' + zoom + ' about ' + x);
    assert.equal(await page.evaluate(() => scrollY), before);
    const pictures = await page.evaluate(() => {
      const viewer = viewers.get(0);
      viewer.hover = null;
      viewer.right = viewer.left;  // the same image in both
      return viewer.update().then(() => viewer.panes.slice(0, 2).map(pane => pane.canvas.toDataURL()));
    });
    assert.equal(pictures[0], pictures[1]);
    await page.mouse.down();
    await page.mouse.move(box.x + box.width * 0.25 - 40, box.y + box.height * 0.25);
    await page.mouse.up();
    assert((await state(page)).x > x, 'a drag pans');
    await page.evaluate(() => viewers.get(0).set({right: 0}));
  },

  async 'pixels are those of the EXR'(page, {out}) {
    for (const number of [0, 1]) {
      const images = await page.evaluate(async number => {
        const viewer = viewers.get(number), {scene} = viewer, plane = scene.width * scene.height, result = [];
        const reference = await viewer.load(scene.images[viewer.reference], null);
        for (const image of scene.images) {
          const pixels = await viewer.load(image, null);
          result.push({exr: image.exr, values: Array.from({length: 3 * plane}, (_, i) => valueAt(scene, pixels, i)),
            errors: Array.from({length: 3 * plane}, (_, i) => differenceAt(scene, image, pixels, reference, i))});
        }
        return result;
      }, number);
      assert.equal(images.length, 6);
      const exact = readExr(path.join(out, images[0].exr));
      for (const image of images) {
        const exr = readExr(path.join(out, image.exr)), plane = exr.width * exr.height;
        for (let i = 0; i < plane; ++i)
          exr.at(i % exr.width, Math.floor(i / exr.width)).forEach((value, channel) => {
            const read = image.values[channel * plane + i];
            assert(Math.abs(read - value) <= 2 ** -11 * Math.abs(value) + 1e-7, image.exr + ': ' + read + ' is ' + value);
            const r = exact.at(i % exr.width, Math.floor(i / exr.width))[channel];
            const error = image.errors[channel * plane + i];
            assert(Math.abs(error - (value - r)) <= 2 ** -10 * (Math.abs(value) + Math.abs(r)) + 1e-7, image.exr + ': error');
          });
      }
    }
  },

  // As a page is that would be too large: the first scene's pixels go to files.
  async 'pixels beside the page are read'(page, {file, url, out}) {
    const whole = fs.readFileSync(file, 'utf8'), [, text] = /id="images">(.*?)<\/script>/s.exec(whole), images = JSON.parse(text);
    fs.mkdirSync(path.join(out, 'viewer'), {recursive: true});
    images.scenes[0].images.forEach((image, i) => {
      const name = 'viewer/' + i + '.js';
      fs.writeFileSync(path.join(out, name), 'pixelData("' + name + '", "' + image.pixels.data + '")\n');
      image.pixels = {file: name};
    });
    images.scenes[1].images[1].frames = [0, 2].map(i => ({time: 0.1 + i, pixels: images.scenes[1].images[i].pixels}));
    fs.writeFileSync(path.join(out, 'beside.html'), whole.replace(text, () => JSON.stringify(images).replaceAll('<', '\\u003c')));
    const picture = () => page.evaluate(async () => {
      const viewer = viewers.get(0);
      await viewer.set({left: 2, right: 0});
      return viewer.panes.map(pane => pane.pixels.toDataURL());
    });
    const expected = await picture();
    await page.goto(url.replace('report.html', 'beside.html'));
    await page.waitForFunction(ready);
    assert.deepEqual(await picture(), expected);
    const [reference, first, second, last, ...names] = await page.evaluate(async () => {
      const viewer = viewers.get(1), looks = [], names = [];
      for (const [left, frame] of [[0, 2], [1, 0], [1, 1], [1, 2]]) {
        await viewer.set({left, frame});
        looks.push(viewer.panes[0].pixels.toDataURL());
        names.push(viewer.parts.leftName.textContent);
      }
      return [...looks, ...names];
    });
    assert(names[1].endsWith(' (after 0.1 s)') && names[2].endsWith(' (after 2.1 s)'), 'a name says which image it is of');
    assert(names[3].includes('relmse'), names[3]);
    assert.equal(first, reference, 'the image at the first checkpoint, which here is the reference');
    assert(second !== first && last !== second && last !== first);
    await page.goto(url);
    await page.waitForFunction(ready);
  },

  async 'the pointer reads values and errors'(page, {out}) {
    await page.evaluate(() => { const viewer = viewers.get(0); viewer.moveTo(0, 0, 1); return viewer.set({left: 1, right: 0}); });
    await page.$eval('.viewer canvas', canvas => canvas.scrollIntoView({block: 'center'}));
    const box = await (await page.$('.viewer canvas')).boundingBox();
    await page.mouse.move(box.x + (20.5 / 48) * box.width, box.y + (15.5 / 32) * box.height);
    await settled(page);
    const text = await shown(page, '.viewer [data-part=values]'), exr = await page.evaluate(() => imageData.scenes[0].images[1].exr);
    assert(text.includes('pixel 20, 15'), text);
    const [red] = /path: (\S+)/.exec(text).slice(1).map(Number), [value] = readExr(path.join(out, exr)).at(20, 15);
    assert(Math.abs(red - value) <= 0.006 * value, red + ' is ' + value);
    assert(text.includes('signed error:'), text);
  },

  async 'a metric changes charts, maps and tables'(page) {
    const look = () => page.evaluate(() => ({
      charts: all('figure.main').map(f => f.querySelector('.stage').dataset.shown),
      drawn: all('figure.main').every(f => f.querySelector('.stage svg')),
      map: document.querySelector('.viewer [data-part=mapName]').textContent,
      table: document.querySelector('figure.table figcaption').textContent}));
    const before = await look();
    for (const metric of ['mse', 'bias']) {
      await page.select('.toolbar select', metric);
      await settled(page);
      const after = await look();
      assert(after.charts.every(chart => chart.startsWith(metric + '|')), after.charts.join(' '));
      assert(after.drawn, metric + ' draws nothing');
      assert.notEqual(after.map, before.map);
      assert(after.table.startsWith(metric), after.table);
    }
    assert.equal((await state(page)).kind, 'signed');
  },

  async 'a reference beside itself keeps the map, by the metric that is chosen'(page) {
    await page.evaluate(() => viewers.get(0).set({left: 2, right: 0}));
    const look = () => page.evaluate(() => ({name: viewers.get(0).parts.mapName.textContent, map: viewers.get(0).panes[2].pixels.toDataURL()}));
    await page.select('.toolbar select', 'mse');
    await settled(page);
    const expected = await look();
    await page.select('.toolbar select', 'relmse');
    await settled(page);
    await page.evaluate(() => viewers.get(0).set({left: 0}));
    await page.select('.toolbar select', 'mse');
    await settled(page);
    assert.deepEqual(await look(), expected);
    assert(expected.name.startsWith('squared error of '), expected.name);
    await page.select('.toolbar select', 'bias');
    await settled(page);
  },

  // The last checkpoint logs the mean of what the map shows.
  async 'a map of FLIP shows what was logged'(page, {out}) {
    const lines = fs.readFileSync(path.join(out, 'runs.jsonl'), 'utf8').trim().split('\n').map(line => JSON.parse(line));
    for (const number of [0, 1]) {
      const {name, label, mean, least, most, options} = await page.evaluate(async number => {
        const viewer = viewers.get(number), {scene} = viewer, image = scene.images[1], count = scene.width * scene.height;
        await viewer.set({left: 1, right: 0, map: 'flip'});
        const errors = Array.from({length: count}, (_, i) => errorAt(scene, image, viewer.now.mapped, viewer.now.reference, mapKinds.flip, i));
        return {name: scene.name, label: image.label, mean: errors.reduce((sum, error) => sum + error) / count,
          least: Math.min(...errors), most: Math.max(...errors), options: [...viewer.parts.kind.options].map(option => option.value)};
      }, number);
      assert(options.includes('flip') && options.includes('relative') && options.includes('signed'), options.join());
      const logged = lines.filter(line => line.type === 'checkpoint' && line.scene === name && line.integrator === label && line.seed === 1).pop();
      assert(Math.abs(mean - logged.metrics.flip) <= 1e-3 * mean + 1e-6, name + ': ' + mean + ' is ' + logged.metrics.flip);
      assert(least >= 0 && most <= 1 && most > least, least + ' to ' + most);
      const text = await page.evaluate(number => {
        const viewer = viewers.get(number);
        viewer.hover = {x: 20, y: 15};
        viewer.readOut();
        return viewer.parts.values.textContent + ' ' + viewer.parts.ticks.textContent + ' ' + viewer.parts.mapName.textContent;
      }, number);
      assert(/FLIP: 0?\.?\d/.test(text) && text.includes('0.25') && text.includes('FLIP of ' + label), text);
      await page.evaluate(number => viewers.get(number).set({map: 'metric'}), number);
    }
    await page.select('.toolbar select', 'flip');
    await settled(page);
    assert.equal((await state(page)).kind, 'flip');
    await page.select('.toolbar select', 'bias');
    await settled(page);
  },

  async 'crops cut every image, and the address keeps the view'(page, {url}) {
    await page.$eval('.viewer canvas', canvas => canvas.scrollIntoView({block: 'center'}));
    const box = await (await page.$('.viewer canvas')).boundingBox();
    await page.keyboard.down('Shift');
    await page.mouse.move(box.x + 20, box.y + 20);
    await page.mouse.down();
    await page.mouse.move(box.x + 90, box.y + 70);
    await page.mouse.up();
    await page.keyboard.up('Shift');
    await page.evaluate(() => { const viewer = viewers.get(0); viewer.moveTo(10, 12, 3); return viewer.set({left: 3, ev: 1.5}); });
    await settled(page);
    assert.equal(await page.evaluate(() => all('.crop-row figure', viewers.get(0).root).length), 6);
    const address = await page.evaluate(() => location.href);
    await page.goto('about:blank');
    await page.goto(address);
    await page.waitForFunction(ready);
    const {left, ev, zoom, kind} = await state(page);
    assert.deepEqual([left, ev, zoom, kind], [3, 1.5, 3, 'signed'], address);
    assert.equal(await page.evaluate(() => viewers.get(0).crops.length), 1);
    await page.goto('about:blank');
    await page.goto(url);
    await page.waitForFunction(ready);
  },

  async 'tables sort and fold'(page) {
    const column = () => page.$$eval('#table-final tbody tr', rows => rows.map(row => row.cells[1].textContent));
    const before = await column();
    await page.click('#table-final th:nth-child(2) button');
    await page.click('#table-final th:nth-child(2) button');
    assert.deepEqual(await column(), before.slice().sort().reverse());
    const unsorted = await page.evaluate(() => all('figure.table table').flatMap(table => all('thead th.num', table).filter(head => {
      const cells = [...table.tBodies[0].rows].map(row => row.cells[head.cellIndex]);
      return cells.some(cell => cell.textContent !== '–') && !cells.some(cell => cell.dataset.v !== undefined);
    }).map(head => table.closest('figure').id + ': ' + head.textContent)));
    assert.deepEqual(unsorted, [], 'columns of figures that take a click and do not sort');
    const columns = () => page.$$eval('#table-final th', heads => heads.filter(head => head.offsetWidth > 0).length);
    const folded = await columns();
    await page.click('#table-final .chips button:nth-child(2)');
    assert(await columns() > folded);
    const rows = text => page.$eval('#table-final', (figure, text) => {
      const filter = figure.querySelector('input[type=search]');
      filter.value = text;
      filter.dispatchEvent(new Event('input'));
      return all('tbody tr', figure).filter(row => row.offsetHeight > 0).length;
    }, text);
    await page.evaluate(() => addFilter(document.querySelector('#table-final')));  // which longer ones have
    assert.equal(await rows(''), before.length);
    const across = await page.$eval('#table-final tbody tr', row => row.cells[0].textContent + row.cells[1].textContent);
    assert.equal(await rows(across), 0, 'found across two cells');
    assert(await rows('path') > 0);
    assert.equal(await rows('unbiased'), 0, 'found in a column that is folded');
    const chip = await page.$$eval('#table-final .chips button', chips => chips.findIndex(chip => chip.textContent.includes('Theory')));
    await page.click('#table-final .chips button:nth-child(' + (chip + 1) + ')');
    assert(await page.$$eval('#table-final tbody tr', rows => rows.some(row => row.offsetHeight > 0)), 'not found where it unfolds');
    await page.click('#table-final .chips button:nth-child(' + (chip + 1) + ')');
    await rows('');
    await page.click('#table-final .chips button:nth-child(2)');
  },

  async 'a phone shows names and cuts nothing'(page) {
    await page.setViewport({width: 390, height: 844, isMobile: true, hasTouch: true});
    await settled(page);
    assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
    const names = await page.$eval('#table-final .scroll', scroll => {
      scroll.scrollLeft = 1000;
      const cell = scroll.querySelector('tbody td').getBoundingClientRect(), box = scroll.getBoundingClientRect();
      return {left: cell.left - box.left, width: cell.width};
    });
    assert(names.left >= -1 && names.width > 30, JSON.stringify(names));
    await page.setViewport({width: 1280, height: 900});
  },

  async 'print cuts no name'(page, {out}) {
    await page.emulateMediaType('print');
    await page.setViewport({width: 760, height: 1100});
    await settled(page);
    const cut = await page.evaluate(() => all('figure.table .scroll').filter(s => s.scrollWidth > s.clientWidth + 1).map(s => s.closest('figure').id));
    assert.deepEqual(cut, []);
    await page.pdf({path: path.join(out, 'report.pdf'), format: 'A4'});
    await page.emulateMediaType(null);
    await page.setViewport({width: 1280, height: 900});
  }
};

async function main() {
  const out = path.join(directory, 'out');
  fs.rmSync(out, {recursive: true, force: true});
  fs.mkdirSync(out, {recursive: true});
  execFileSync(etendue, ['run', path.join(__dirname, 'hundred-cells.toml'), '--out', out], {stdio: 'pipe'});
  const browser = await puppeteer.launch({executablePath: chromium, headless: true, args: ['--no-sandbox', '--disable-gpu']});
  let failed = 0;
  try {
    const page = await browser.newPage(), file = path.join(out, 'report.html'), url = 'file://' + path.resolve(file);
    const troubles = [];
    page.on('console', message => { if (message.type() === 'error') troubles.push(message.text()); });
    page.on('pageerror', error => troubles.push(String(error)));
    page.on('request', request => { if (!/^(file|data|blob|about):/.test(request.url())) troubles.push('asks for ' + request.url()); });
    await page.setViewport({width: 1280, height: 900});
    for (const [name, check] of Object.entries(checks)) {
      try {
        await check(page, {file, url, out});
        console.log('ok: ' + name);
      } catch (error) {
        ++failed;
        console.log('FAILED: ' + name + ': ' + error.message);
      }
    }
    if (troubles.length) {
      ++failed;
      console.log('FAILED: the console has errors: ' + troubles.join('; '));
    }
  } finally {
    await browser.close();
  }
  process.exitCode = failed ? 1 : 0;
}
main().catch(error => { console.log(error); process.exitCode = 1; });
