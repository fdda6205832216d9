import type { FileOrder, FilePart } from "../protocol/file_messages";
import type { Problem } from "../protocol/messages";
import { UnseenSession, type UnseenParts, type UnseenState } from "./unseen";

/** As much of the protocol's bounds as the page asks about. */
export const longest_film_side = 1920;
export const longest_film_s = 60;
export const longest_large_side = 16384;

/** The session renders nothing for itself: the smallest there is. */
const unseen = { width: 16, height: 16 };
/** Parts that lie in the page's memory before the browser has them, which may put them on a disk. */
const parts_in_memory = 64;

export type FileState = UnseenState<{ readonly kind: "done"; readonly file: Blob }, "busy">;

/**
 * A file that a worker makes: a film, or a picture larger than a page holds. Its session renders nothing but the file.
 * Where its worker is lost, another makes it anew.
 */
export class FileShot {
  private readonly session_: UnseenSession<{ readonly kind: "done"; readonly file: Blob }, "busy">;
  private parts_seen_ = 0n;
  private fresh_: Uint8Array<ArrayBuffer>[] = [];
  private file_: Blob;

  constructor(
    private readonly order_: FileOrder,
    parts: UnseenParts<FileState>,
  ) {
    this.file_ = this.empty();
    const state = (now: FileState) => {
      if (now.kind !== "rendering") this.fresh_ = [];
      parts.state(now);
    };
    this.session_ = new UnseenSession({ ...parts, state }, unseen, [], {
      config: () => this.ask(),
      frame: (frame) => this.session_.client.ack(frame, { received_ms: 0 }, 0),
      problem: (problem) => this.refused(problem),
      file_progress: (done) => this.session_.is_at(Math.min(1, Math.max(0, done))),
      file_part: (part) => this.receive(part),
    });
    this.session_.client.set_visible(false);
  }

  start(): void {
    this.session_.start();
  }

  stop(): void {
    this.session_.stop();
  }

  /** Of a new connection: from the beginning. */
  private ask(): void {
    this.parts_seen_ = 0n;
    this.fresh_ = [];
    this.file_ = this.empty();
    this.session_.is_at(null);
    this.session_.client.ask_for_file(this.order_);
  }

  private receive(part: FilePart): void {
    if (this.session_.is_over()) return;
    if (part.seq !== this.parts_seen_ + 1n) { this.session_.fail("refused", ""); return; }
    this.parts_seen_ = part.seq;
    this.fresh_.push(new Uint8Array(part.data));
    if (this.fresh_.length >= parts_in_memory || part.last) {
      this.file_ = new Blob([this.file_, ...this.fresh_], { type: this.file_.type });
      this.fresh_ = [];
    }
    this.session_.client.file_taken(part);
    if (part.last) this.session_.finish({ kind: "done", file: this.file_ });
  }

  private refused({ code, field, fatal, message }: Problem): void {
    if (field === "file" && code === "too_many") this.session_.fail("busy", "");
    else if (field === "file" || !fatal) this.session_.fail("refused_scene", message);
  }

  private empty(): Blob {
    return new Blob([], { type: this.order_.kind === "picture" ? "image/png" : "video/mp4" });
  }
}
