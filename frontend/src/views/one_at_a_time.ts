/** Runs `work` and ignores further calls until it has ended, because nobody means a double click twice. */
export function oneAtATime<Given extends unknown[]>(
  work: (...given: Given) => Promise<unknown>,
): (...given: Given) => void {
  let running = false;
  return (...given) => {
    if (running) return;
    running = true;
    void work(...given).finally(() => (running = false));
  };
}
