/** Files that arrive one by one while the first ones are already being read. */
export class Arriving {
  private readonly arrived: Blob[] = [];
  private waiting: (() => void)[] = [];

  constructor(readonly total: number) {}

  get files(): readonly Blob[] {
    return this.arrived;
  }

  add(files: readonly Blob[]): void {
    this.arrived.push(...files);
    const waiting = this.waiting;
    this.waiting = [];
    for (const wake of waiting) wake();
  }

  /** Resolves once the file has arrived. `index` is below `total`. */
  async file(index: number): Promise<Blob | undefined> {
    while (index >= this.arrived.length) await new Promise<void>((wake) => this.waiting.push(wake));
    return this.arrived[index];
  }
}

export function allThere(files: readonly Blob[]): Arriving {
  const arriving = new Arriving(files.length);
  arriving.add(files);
  return arriving;
}
