export interface Polling {
  /**
   * Begins the next round at once, or when the current one ends, because that may have started too
   * early.
   */
  readonly now: () => void;
  readonly stop: () => void;
}

/** Runs rounds one after the other. Each returns the time in ms until the next one. */
export function startPolling(round: () => Promise<number>): Polling {
  let timer: ReturnType<typeof setTimeout> | undefined;
  let isRunning = false;
  let isWanted = false;
  let isStopped = false;
  const run = async () => {
    isRunning = true;
    const wait = await round();
    isRunning = false;
    if (isStopped) return;
    timer = setTimeout(() => void run(), isWanted ? 0 : wait);
    isWanted = false;
  };
  void run();
  return {
    now: () => {
      if (isStopped) return;
      if (isRunning) {
        isWanted = true;
        return;
      }
      clearTimeout(timer);
      void run();
    },
    stop: () => {
      isStopped = true;
      clearTimeout(timer);
    },
  };
}
