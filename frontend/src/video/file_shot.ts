import { open_browser_socket } from "../protocol/browser_socket";
import type { Trouble } from "../protocol/connection";
import type { FileOrder, FilePart } from "../protocol/file_messages";
import { Codec, type Problem } from "../protocol/messages";
import { StreamClient, type Door, type OpenSocket } from "../protocol/stream_client";
import { unheard } from "./unseen";

/** As much of the protocol's bounds as the page asks about. */
export const longest_film_side = 1920;
export const longest_film_s = 60;
export const longest_large_side = 16384;

/** The session renders nothing for itself: the smallest there is. */
const unseen = { width: 16, height: 16 };
/** Parts that lie in the page's memory before the browser has them, which may put them on a disk. */
const parts_in_memory = 64;

export type FileState =
  | { readonly kind: "rendering"; readonly done: number | null; readonly waits: Trouble | null }
  | { readonly kind: "done"; readonly file: Blob }
  | { readonly kind: "failed"; readonly trouble: Trouble | "refused_scene" | "stopped" | "busy"; readonly said: string };

export interface FileParts {
  readonly door: Door;
  readonly open_socket: OpenSocket;
  readonly after: (ms: number, task: () => void) => () => void;
  readonly state: (state: FileState) => void;
}

/**
 * A file that a worker makes: a film, or a picture larger than a page holds. A session more of the same scan, which
 * nobody sees and which renders nothing but the file. Where its worker is lost, another makes it anew.
 */
export class FileShot {
  private readonly client_: StreamClient;
  private over_ = false;
  private done_: number | null = null;
  private waits_: Trouble | null = null;
  private parts_seen_ = 0n;
  private fresh_: Uint8Array<ArrayBuffer>[] = [];
  private file_: Blob;

  constructor(
    private readonly order_: FileOrder,
    private readonly parts_: FileParts,
  ) {
    this.file_ = this.empty();
    this.client_ = new StreamClient(
      {
        door: parts_.door,
        open_socket: parts_.open_socket,
        next_frame: (task) => void parts_.after(0, task), // also while nobody looks at the page
        after: parts_.after,
        chance: Math.random,
        abilities: { codecs: [Codec.JPEG], stills: [] },
        pixel_ratio: () => 1,
      },
      {
        ...unheard,
        connection: ({ phase, trouble }) => {
          if (trouble !== null && (phase === "stopped" || phase === "elsewhere")) this.fail(trouble, "");
          else if (!this.over_ && trouble !== this.waits_) {
            this.waits_ = trouble;
            this.tell();
          }
        },
        config: () => this.ask(),
        frame: (frame) => this.client_.ack(frame, { received_ms: 0 }, 0),
        problem: (problem) => this.refused(problem),
        file_progress: (done) => {
          this.done_ = Math.min(1, Math.max(0, done));
          this.tell();
        },
        file_part: (part) => this.receive(part),
      },
      unseen,
    );
    this.client_.set_visible(false);
  }

  start(): void {
    this.tell();
    this.client_.start();
  }

  stop(): void {
    this.fail("stopped", "");
  }

  /** Of a new connection: from the beginning. */
  private ask(): void {
    this.parts_seen_ = 0n;
    this.fresh_ = [];
    this.file_ = this.empty();
    this.done_ = null;
    this.tell();
    this.client_.ask_for_file(this.order_);
  }

  private receive(part: FilePart): void {
    if (this.over_) return;
    if (part.seq !== this.parts_seen_ + 1n) { this.fail("refused", ""); return; }
    this.parts_seen_ = part.seq;
    this.fresh_.push(new Uint8Array(part.data));
    if (this.fresh_.length >= parts_in_memory || part.last) {
      this.file_ = new Blob([this.file_, ...this.fresh_], { type: this.file_.type });
      this.fresh_ = [];
    }
    this.client_.file_taken(part);
    if (part.last) this.finish({ kind: "done", file: this.file_ });
  }

  private refused({ code, field, fatal, message }: Problem): void {
    if (field === "file" && code === "too_many") this.fail("busy", "");
    else if (field === "file" || !fatal) this.fail("refused_scene", message);
  }

  private tell(): void {
    if (!this.over_) this.parts_.state({ kind: "rendering", done: this.done_, waits: this.waits_ });
  }

  private fail(trouble: Extract<FileState, { kind: "failed" }>["trouble"], said: string): void {
    this.finish({ kind: "failed", trouble, said });
  }

  private finish(state: FileState): void {
    if (this.over_) return;
    this.over_ = true;
    this.fresh_ = [];
    this.client_.stop();
    this.parts_.state(state);
  }

  private empty(): Blob {
    return new Blob([], { type: this.order_.kind === "picture" ? "image/png" : "video/mp4" });
  }
}

/** With the browser's own parts, and an own session of the scan. */
export const browser_file_parts = (door: Door, state: (state: FileState) => void): FileParts => ({
  door,
  open_socket: open_browser_socket,
  after: (ms, task) => {
    const timer = setTimeout(task, ms);
    return () => clearTimeout(timer);
  },
  state,
});
