/**
 * The longest time that a loop may block the page. Users do not notice it, and each pause costs a turn of the event
 * loop.
 */
const longestMs = 24;

/**
 * Returns a function for loops of many small steps. Awaiting its result between steps keeps the
 * page responsive.
 */
export function pauses(): () => Promise<void> | undefined {
  let began = performance.now();
  return () => {
    if (performance.now() - began < longestMs) return undefined;
    return new Promise((resolve) => {
      const { port1, port2 } = new MessageChannel(); // setTimeout would wait for at least 4 ms each time
      port1.onmessage = () => {
        port1.close();
        began = performance.now();
        resolve();
      };
      port2.postMessage(null);
    });
  };
}
