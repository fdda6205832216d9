import type { StreamEvents } from "../protocol/stream_client";

const nothing = () => undefined;

/** What a session that nobody sees has no use for. */
export const unheard: StreamEvents = {
  connection: nothing,
  config: nothing,
  frame: nothing,
  still: nothing,
  slice: nothing,
  audience: nothing,
  look: nothing,
  state: nothing,
  stats: nothing,
  problem: nothing,
  file_progress: nothing,
  file_part: nothing,
  kernel: nothing,
};
