import type { FileOrder, FilePart } from "../protocol/file_messages";
import type { Problem } from "../protocol/messages";
import { BackgroundSession, type BackgroundParts, type BackgroundState } from "./background_session";

/** Limits of the protocol that the page checks. */
export const longestVideoSide = 1920;
export const longestVideoS = 60;
export const longestLargeSide = 16384;

/** The session renders no picture of its own, so its size is the smallest possible one. */
const smallestSize = { width: 16, height: 16 };
/**
 * Maximum number of parts in the page's memory before they are handed to the browser, which may store them on a disk.
 */
const partsInMemory = 64;

export type FileState = BackgroundState<{ readonly kind: "done"; readonly file: Blob }, "busy">;

/**
 * A file that a worker creates: a video, or a picture that is too large for a page. Its session renders nothing else. If
 * the worker is lost, another one starts again.
 */
export class FileShot {
  private readonly session: BackgroundSession<{ readonly kind: "done"; readonly file: Blob }, "busy">;
  private partsSeen = 0n;
  private fresh: Uint8Array<ArrayBuffer>[] = [];
  private file: Blob;

  constructor(
    private readonly order: FileOrder,
    parts: BackgroundParts<FileState>,
  ) {
    this.file = this.empty();
    const state = (now: FileState) => {
      if (now.kind !== "rendering") this.fresh = [];
      parts.state(now);
    };
    this.session = new BackgroundSession({ ...parts, state }, smallestSize, [], {
      config: () => this.ask(),
      frame: (frame) => this.session.client.ack(frame, { receivedMs: 0 }, 0),
      problem: (problem) => this.refused(problem),
      fileProgress: (done) => this.session.reportProgress(Math.min(1, Math.max(0, done))),
      filePart: (part) => this.receive(part),
    });
    this.session.client.setVisible(false);
  }

  start(): void {
    this.session.start();
  }

  stop(): void {
    this.session.stop();
  }

  /** Orders the file from the beginning on a new connection. */
  private ask(): void {
    this.partsSeen = 0n;
    this.fresh = [];
    this.file = this.empty();
    this.session.reportProgress(null);
    this.session.client.askForFile(this.order);
  }

  private receive(part: FilePart): void {
    if (this.session.isOver()) return;
    if (part.seq !== this.partsSeen + 1n) {
      this.session.fail("refused", "");
      return;
    }
    this.partsSeen = part.seq;
    this.fresh.push(new Uint8Array(part.data));
    if (this.fresh.length >= partsInMemory || part.last) {
      this.file = new Blob([this.file, ...this.fresh], { type: this.file.type });
      this.fresh = [];
    }
    this.session.client.fileTaken(part);
    if (part.last) this.session.finish({ kind: "done", file: this.file });
  }

  private refused({ code, field, fatal, message }: Problem): void {
    if (field === "file" && code === "too_many") this.session.fail("busy", "");
    else if (field === "file" || !fatal) this.session.fail("refused_scene", message);
  }

  private empty(): Blob {
    return new Blob([], { type: this.order.kind === "picture" ? "image/png" : "video/mp4" });
  }
}
