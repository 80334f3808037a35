// The one time of the page: animation, scrubber and charts all follow it. A time is a sample of the run.

export class Clock {
  constructor() {
    this.listeners = new Set();
    this.time = new Float64Array([0, 1]);
    this.sample = 0;
    this.playing = false;
    this.speed = 1;
    this.loop = true;
    this.last = 0;
    this.now = 0;
  }

  /** Another run: the same instant of it, or its end. */
  setTimes(time) {
    const now = this.now;
    this.time = time;
    this.seek(now);
  }

  get duration() {
    return this.time[this.time.length - 1];
  }

  onChange(listener) {
    this.listeners.add(listener);
  }

  tell() {
    for (const listener of this.listeners) listener(this);
  }

  /** To the sample nearest to a time [s]. */
  seek(seconds) {
    this.now = Math.min(Math.max(seconds, this.time[0]), this.duration);
    this.sample = nearest(this.time, this.now);
    this.tell();
  }

  seekSample(sample) {
    this.sample = Math.min(Math.max(Math.round(sample), 0), this.time.length - 1);
    this.now = this.time[this.sample];
    this.tell();
  }

  step(samples) {
    this.pause();
    this.seekSample(this.sample + samples);
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  play() {
    if (this.playing) return;
    this.playing = true;
    if (this.now >= this.duration) this.now = this.time[0];
    this.last = performance.now();
    requestAnimationFrame((t) => this.frame(t));
    this.tell();
  }

  pause() {
    if (!this.playing) return;
    this.playing = false;
    this.tell();
  }

  frame(stamp) {
    if (!this.playing) return;
    const now = this.now + (Math.max(stamp - this.last, 0) / 1000) * this.speed;
    this.last = stamp;
    if (now < this.duration) {
      this.seek(now);
    } else if (this.loop) {
      this.seek(this.duration); // the end is seen before the start is
      this.now = this.time[0];
    } else {
      this.seek(this.duration);
      this.pause();
    }
    requestAnimationFrame((t) => this.frame(t));
  }
}

/** Index of the value nearest to x in an increasing list. */
export function nearest(list, x) {
  let low = 0;
  let high = list.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (list[middle] <= x) low = middle;
    else high = middle;
  }
  return x - list[low] <= list[high] - x ? low : high;
}
