/** So long at a stretch may a loop hold up the page: a hand does not notice it, and each stop costs a turn of the page. */
const longestMs = 24;

/** For work in many small steps: call between them, and await what it gives; the page lives on meanwhile. */
export function pauses(): () => Promise<void> | undefined {
  let began = performance.now();
  return () => {
    if (performance.now() - began < longestMs) return undefined;
    return new Promise((goOn) => {
      const { port1, port2 } = new MessageChannel(); // setTimeout would wait for 4 ms each time
      port1.onmessage = () => {
        port1.close();
        began = performance.now();
        goOn();
      };
      port2.postMessage(null);
    });
  };
}
