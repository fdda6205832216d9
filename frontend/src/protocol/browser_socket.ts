import { subprotocol } from "./messages";
import { probeLimitMs } from "./silence_watch";
import type { OpenSocket } from "./stream_client";

/** Opens a WebSocket. `url` is a path on the page's origin. */
export const openBrowserSocket: OpenSocket = (url, events) => {
  const address = new URL(url, location.href);
  address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
  const socket = new WebSocket(address, subprotocol);
  socket.binaryType = "arraybuffer";
  socket.onopen = () => events.opened();
  socket.onclose = (event) => events.closed(event.code);
  socket.onmessage = (event: MessageEvent<unknown>) => {
    if (event.data instanceof ArrayBuffer) events.message(new Uint8Array(event.data));
  };
  return {
    send: (data) => {
      if (socket.readyState === WebSocket.OPEN) socket.send(data);
    },
    close: () => socket.close(1000),
  };
};

/** Returns whether the server can be reached. Any response counts, even an error. */
export async function probeServer(): Promise<boolean> {
  try {
    await fetch("/", { method: "HEAD", cache: "no-store", signal: AbortSignal.timeout(probeLimitMs) });
    return true;
  } catch {
    return false;
  }
}
