// A picture that the kernel renders and the pointer turns.

/** Most device pixels for a CSS pixel. */
const DENSEST = 2;
/** Inputs that may be under way to the kernel. More of them wait, and become one. */
const MOST_INPUTS = 2;
/** Milliseconds after which an input counts as heard. */
const LOST_MS = 1000;
/** Milliseconds without an answer after which the kernel counts as busy. */
const BUSY_MS = 3000;
/** Milliseconds that a size lasts before pictures of it are asked for. */
const RESIZED_MS = 120;
/** Milliseconds after the page scrolled in which the wheel goes on scrolling. */
const SCROLLING_MS = 300;
/** Milliseconds from one gaze to the next. */
const GAZE_MS = 100;
/** What a step of the wheel and a key do: factors, and heights of the picture. */
const WHEEL_FACTOR = 1.0015;
const KEY_FACTOR = 1.2;
const KEY_STEP = 0.04;

const BUSY = "The kernel is busy. The picture follows when it is free.";
const GONE = "The kernel has ended or was restarted. Run the cell again.";
const SAVED = "A saved picture. Run the cell to turn it.";

/** Name of this page. Every widget imports its own copy of this module. */
const page = (globalThis[Symbol.for("fovolnet.page")] ??= newName());

function newName() {
  // Without HTTPS there is no `randomUUID`.
  return crypto.randomUUID?.() ?? String(Math.random());
}

/** Bytes of a buffer as any notebook hands it over. */
function bytesOf(buffer) {
  if (buffer instanceof ArrayBuffer) return new Uint8Array(buffer);
  return new Uint8Array(buffer.buffer, buffer.byteOffset, buffer.byteLength);
}

/** A bitmap of an encoded picture. */
function bitmapOf(encoding, bytes, width, height) {
  if (encoding === "raw") {
    const pixels = new Uint8ClampedArray(bytes.slice().buffer);
    return createImageBitmap(new ImageData(pixels, width, height));
  }
  return createImageBitmap(new Blob([bytes], { type: `image/${encoding}` }));
}

/** Draws the newest of the frames that arrive. */
class Screen {
  constructor(canvas, drawn) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d", { alpha: false });
    this.drawn = drawn;
    this.next = null;
    this.isDrawing = false;
  }

  async show(frame) {
    this.next = frame;
    if (this.isDrawing) return;
    this.isDrawing = true;
    try {
      while (this.next) {
        const now = this.next;
        this.next = null;
        const bitmap = await bitmapOf(now.encoding, now.bytes, now.width, now.height);
        const [width, height] = now.size ?? [bitmap.width, bitmap.height];
        if (this.canvas.width !== width || this.canvas.height !== height) {
          this.canvas.width = width;
          this.canvas.height = height;
        }
        // Frames in motion may be smaller than the picture.
        this.context.imageSmoothingQuality = "medium";
        this.context.drawImage(bitmap, 0, 0, width, height);
        bitmap.close();
        this.drawn(now);
      }
    } finally {
      this.isDrawing = false;
    }
  }
}

/** Sends what pointer, wheel and keys do. What happens while others are under way becomes one message. */
class Inputs {
  constructor(send) {
    this.send = send;
    this.waiting = null;
    this.sent = 0;
    this.heard = 0;
    this.sentAt = 0;
    this.heardAt = 0;
    this.gaze = [0.5, 0.5];
    this.held = false;
    this.timer = 0;
    this.frame = 0;
  }

  add(change) {
    const waiting = (this.waiting ??= {});
    for (const kind of ["turn", "pan"]) {
      if (!change[kind]) continue;
      const [right, down] = waiting[kind] ?? [0, 0];
      waiting[kind] = [right + change[kind][0], down + change[kind][1]];
    }
    if (change.zoom) {
      const [factor, right, down] = change.zoom;
      waiting.zoom = [factor * (waiting.zoom?.[0] ?? 1), right, down];
    }
    if (change.home) this.waiting = { home: true };
    // Pointers report more often than the screen is drawn.
    if (!this.frame) {
      this.frame = requestAnimationFrame(() => {
        this.frame = 0;
        this.flush();
      });
    }
  }

  flush() {
    clearTimeout(this.timer);
    if (!this.waiting) return;
    const left = this.sentAt + LOST_MS - performance.now();
    if (this.sent - this.heard >= MOST_INPUTS && left > 0) {
      this.timer = setTimeout(() => this.flush(), left);
      return;
    }
    this.sent += 1;
    this.sentAt = performance.now();
    const { waiting, sent: number, gaze, held } = this;
    this.waiting = null;
    this.send({ kind: "input", number, gaze, held, ...waiting });
  }

  /** The kernel has heard inputs up to `number`. */
  hear(number) {
    this.heardAt = performance.now();
    this.heard = Math.max(this.heard, number);
    this.flush();
  }

  get isUnheard() {
    return this.sent > this.heard;
  }

  stop() {
    clearTimeout(this.timer);
    cancelAnimationFrame(this.frame);
  }
}

/** Turns events of pointers into inputs. Coordinates are in heights of the picture. */
function followPointers(canvas, inputs, signal) {
  const pointers = new Map();
  const options = { signal };
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    inputs.gaze = [x / box.width, y / box.height];
    return { right: (x - box.width / 2) / box.height, down: (y - box.height / 2) / box.height };
  };
  const middle = () => {
    const all = [...pointers.values()];
    const mean = (of) => all.reduce((sum, one) => sum + of(one), 0) / all.length;
    const [right, down] = [mean((one) => one.right), mean((one) => one.down)];
    return { right, down, spread: mean((one) => Math.hypot(one.right - right, one.down - down)) };
  };

  canvas.addEventListener(
    "pointerdown",
    (event) => {
      canvas.focus({ preventScroll: true });
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, { ...place(event), pans: event.button === 2 || event.button === 1 || event.shiftKey });
      inputs.held = true;
      event.preventDefault();
    },
    options,
  );
  canvas.addEventListener(
    "pointermove",
    (event) => {
      const last = pointers.get(event.pointerId);
      const now = place(event);
      if (!last) return;
      const before = middle();
      pointers.set(event.pointerId, { ...now, pans: last.pans });
      const after = middle();
      const way = [after.right - before.right, after.down - before.down];
      if (pointers.size > 1) {
        const factor = after.spread > 0 ? before.spread / after.spread : 1;
        inputs.add({ pan: way, zoom: [factor, after.right, after.down] });
      } else {
        inputs.add(last.pans ? { pan: way } : { turn: way });
      }
    },
    options,
  );
  const release = (event) => {
    if (!pointers.delete(event.pointerId) || pointers.size) return;
    inputs.held = false;
    inputs.add({});
  };
  canvas.addEventListener("pointerup", release, options);
  canvas.addEventListener("pointercancel", release, options);
  canvas.addEventListener("contextmenu", (event) => event.preventDefault(), options);
  canvas.addEventListener("dblclick", () => inputs.add({ home: true }), options);

  // A page that scrolls past the picture goes on scrolling.
  let scrolledAt = -Infinity;
  const scrolled = () => (scrolledAt = performance.now());
  document.addEventListener("scroll", scrolled, { signal, capture: true, passive: true });
  canvas.addEventListener(
    "wheel",
    (event) => {
      if (performance.now() - scrolledAt < SCROLLING_MS) return;
      event.preventDefault();
      const lines = [1, 16, canvas.clientHeight][event.deltaMode] ?? 1;
      const { right, down } = place(event);
      const way = Math.max(-400, Math.min(400, event.deltaY * lines));
      inputs.add({ zoom: [WHEEL_FACTOR ** way, right, down] });
    },
    { signal, passive: false },
  );
}

/** Turns keys into inputs. */
function followKeys(canvas, inputs, signal) {
  const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  canvas.addEventListener(
    "keydown",
    (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const way = ways[event.key]?.map((step) => step * KEY_STEP);
      if (way) inputs.add(event.shiftKey ? { pan: way } : { turn: way });
      else if (event.key === "+" || event.key === "=") inputs.add({ zoom: [1 / KEY_FACTOR, 0, 0] });
      else if (event.key === "-") inputs.add({ zoom: [KEY_FACTOR, 0, 0] });
      else if (event.key === "0" || event.key === "Home") inputs.add({ home: true });
      else return;
      event.preventDefault();
      event.stopPropagation();
    },
    { signal },
  );
}

/** Calls `ask` with the size in device pixels whenever it has changed. */
function followSize(box, ask, signal) {
  let asked = "";
  let timer = 0;
  const look = () => {
    const density = Math.min(window.devicePixelRatio || 1, DENSEST);
    const [width, height] = [box.clientWidth, box.clientHeight].map((side) => Math.round(side * density));
    // A hidden output has no size.
    if (!width || !height || asked === `${width}x${height}`) return;
    const isFirst = asked === "";
    asked = `${width}x${height}`;
    ask(width, height, isFirst);
  };
  const observer = new ResizeObserver(() => {
    clearTimeout(timer);
    timer = setTimeout(look, asked ? RESIZED_MS : 0);
  });
  observer.observe(box);
  signal.addEventListener("abort", () => {
    clearTimeout(timer);
    observer.disconnect();
  });
}

function render({ model, el }) {
  const view = newName();
  const ending = new AbortController();
  const { signal } = ending;
  const box = document.createElement("div");
  const canvas = document.createElement("canvas");
  const line = document.createElement("p");
  const [width, height] = model.get("_size");
  box.className = "fovolnet";
  // Otherwise the notebook takes the keys.
  box.dataset.lmSuppressShortcuts = "true";
  box.style.width = `${width + 2}px`;
  box.style.aspectRatio = `${width + 2} / ${height + 2}`;
  canvas.tabIndex = 0;
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", model.get("_label"));
  line.setAttribute("role", "status");
  box.append(canvas, line);
  el.append(box);

  let isHeard = false;
  let error = "";
  let openedAt = 0;
  const send = (message) => {
    try {
      model.send({ ...message, view, page });
    } catch {
      tell(GONE);
    }
  };
  const tell = (text) => {
    if (line.textContent !== text) line.textContent = text;
  };
  const inputs = new Inputs(send);
  const screen = new Screen(canvas, (frame) => {
    if (frame.number === undefined) return;
    box.dataset.frames = String(Number(box.dataset.frames ?? 0) + 1);
    box.dataset.share = String(frame.share);
    send({ kind: "drawn", number: frame.number });
  });
  const showStill = () => {
    const still = model.get("_still");
    if (isHeard || !still?.byteLength) return;
    const bytes = bytesOf(still);
    screen.show({ encoding: bytes[0] === 0x89 ? "png" : "jpeg", bytes });
  };

  model.on("msg:custom", (message, buffers) => {
    isHeard = true;
    if (message.kind === "frame") {
      error = "";
      screen.show({ ...message, bytes: bytesOf(buffers[0]) });
    } else if (message.kind === "error") {
      error = message.text;
    }
    tell(error);
    inputs.hear(message.heard?.[view] ?? 0);
  });
  model.on("change:_still", showStill);
  // Notebooks of Jupyter say so when a kernel restarts.
  model.on("comm_live_update", () => isHeard && tell(GONE));

  let lookedAt = 0;
  canvas.addEventListener(
    "pointermove",
    (event) => {
      const now = performance.now();
      if (event.buttons || !(Number(box.dataset.share) < 1) || now - lookedAt < GAZE_MS) return;
      lookedAt = now;
      send({ kind: "gaze", gaze: inputs.gaze });
    },
    { signal },
  );
  followPointers(canvas, inputs, signal);
  followKeys(canvas, inputs, signal);
  followSize(
    canvas,
    (width, height, isFirst) => {
      openedAt ||= performance.now();
      send({ kind: isFirst ? "open" : "size", width, height });
    },
    signal,
  );
  const shut = () => send({ kind: "shut" });
  window.addEventListener("pagehide", shut, { signal });
  const watch = setInterval(() => {
    const now = performance.now();
    if (line.textContent === GONE) return;
    if (!isHeard && openedAt && now - openedAt > BUSY_MS) tell(model.get("_still")?.byteLength ? SAVED : BUSY);
    else if (inputs.isUnheard && now - Math.max(inputs.sentAt, inputs.heardAt) > BUSY_MS) tell(BUSY);
  }, 500);
  showStill();

  return () => {
    ending.abort();
    clearInterval(watch);
    inputs.stop();
    shut();
    box.remove();
  };
}

export default { render };
