// Decides which frames of the screen show a new picture, so that the pictures have a mean rate of their
// own: 40 Hz is no part of 60 Hz, and single gaps are then 16.7 ms and 33.3 ms, with a mean of 25 ms.

// Frames of the screen come at times that jitter. A picture may come this much early, so that a frame at
// its time shows it whatever the jitter.
const kEarly_ms = 1;

export class PicturePacer {
  private readonly period_ms: number;
  private due_ms = -Infinity; // when the next picture is due

  constructor(rate_Hz: number) {
    this.period_ms = 1000 / rate_Hz;
  }

  // Whether the frame at this time shows a new picture. Call it once a frame, with growing times. After a
  // pause of the browser the pictures that it left out are not made up for.
  isDue(now_ms: number): boolean {
    if (now_ms < this.due_ms - kEarly_ms) return false;
    if (this.due_ms === -Infinity) this.due_ms = now_ms;
    const periods = Math.ceil((now_ms - this.due_ms) / this.period_ms);
    this.due_ms += Math.max(1, periods) * this.period_ms;
    return true;
  }
}
