type Task = () => Promise<void>;

/**
 * Runs tasks one by one. Tasks that a user waits for take precedence over those that prepare
 * something.
 */
export class TaskQueue {
  private readonly awaited: Task[] = [];
  private readonly preparing: Task[] = [];
  private running = false;

  add<T>(task: () => Promise<T>): Promise<T> {
    return this.append(this.awaited, task);
  }

  addPreparation<T>(task: () => Promise<T>): Promise<T> {
    return this.append(this.preparing, task);
  }

  private append<T>(queue: Task[], task: () => Promise<T>): Promise<T> {
    const result = new Promise<T>((resolve, reject) => {
      queue.push(() => task().then(resolve, reject));
    });
    if (!this.running) void this.run();
    return result;
  }

  private async run(): Promise<void> {
    this.running = true;
    for (let next = this.next(); next; next = this.next()) await next();
    this.running = false;
  }

  private next(): Task | undefined {
    return this.awaited.shift() ?? this.preparing.shift();
  }
}
