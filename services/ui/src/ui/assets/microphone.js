// Runs beside the page, where sound arrives: what the microphone hears as 16 kHz 16-bit mono, a tenth of a second at a time.
const RATE_HZ = 16000;
const CHUNK = RATE_HZ / 10;

registerProcessor("atom-microphone", class extends AudioWorkletProcessor {
  constructor() {
    super();
    this.step = sampleRate / RATE_HZ;  // a browser may not run the microphone at another rate than the machine's
    this.due = 0;
    this.sum = 0;
    this.count = 0;
    this.mean = 0;
    this.begin();
  }

  begin() {
    this.chunk = new Int16Array(CHUNK);
    this.filled = 0;
    this.squares = 0;
  }

  process(inputs) {
    const samples = inputs[0] && inputs[0][0];
    if (!samples) return true;
    for (const sample of samples) {
      this.sum += sample;
      this.count += 1;
      this.due += 1;
      while (this.due >= this.step) {
        this.due -= this.step;
        if (this.count > 0) this.mean = this.sum / this.count;
        this.sum = 0;
        this.count = 0;
        this.put(Math.max(-1, Math.min(1, this.mean)));
      }
    }
    return true;
  }

  put(value) {
    this.squares += value * value;
    this.chunk[this.filled] = Math.round(value * 32767);
    this.filled += 1;
    if (this.filled < CHUNK) return;
    const { buffer } = this.chunk;
    this.port.postMessage({ samples: buffer, level: Math.sqrt(this.squares / CHUNK) }, [buffer]);
    this.begin();
  }
});
