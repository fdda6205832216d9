/**
 * Runs `work` and ignores further calls until it has ended, so that a double click does not run it
 * twice.
 */
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
