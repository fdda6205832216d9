/** Files that come one after the other while the first are looked at already. */
export class Arriving {
  private readonly files_: Blob[] = [];
  private waiting_: (() => void)[] = [];

  constructor(readonly total: number) {}

  get files(): readonly Blob[] {
    return this.files_;
  }

  add(files: readonly Blob[]): void {
    this.files_.push(...files);
    const waiting = this.waiting_;
    this.waiting_ = [];
    for (const wake of waiting) wake();
  }

  /** Resolves once it is there; `index` is below `total`. */
  async file(index: number): Promise<Blob | undefined> {
    while (index >= this.files_.length) await new Promise<void>((wake) => this.waiting_.push(wake));
    return this.files_[index];
  }
}

export function all_there(files: readonly Blob[]): Arriving {
  const arriving = new Arriving(files.length);
  arriving.add(files);
  return arriving;
}
