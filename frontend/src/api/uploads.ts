import { signal, type ReadonlySignal } from "@preact/signals";
import { makeBundle } from "../scan/bundle";
import { local } from "../storage";
import { ApiProblem, type Api } from "./client";
import { randomKey } from "./random_key";
import { TabCoordinator } from "./tab_coordinator";
import { startUpload, type RunningUpload } from "./upload";
import { forgetUpload, rememberUpload, rememberedUpload, type RememberedUpload } from "./upload_memory";
import { begun, stalled, inPhase, isOpen, nextToSend, refused, withProgress, type UploadView } from "./upload_view";

export type { UploadView } from "./upload_view";

/**
 * Maximum number of parallel uploads. More would only share the bandwidth, and browsers open at
 * most six connections per host.
 */
const atOnce = 3;
const reportedEveryMs = 1000;

interface Own {
  readonly bundle: Blob;
  readonly url: string;
  running: RunningUpload | null;
}

/** Thrown by `start` if another window of this browser is already uploading these files. */
export class SentElsewhere extends Error {}

/** The uploads of this page. They continue while the user visits other pages. */
export class Uploads {
  private readonly uploadViews = signal<ReadonlyMap<string, UploadView>>(new Map());
  private readonly own = new Map<string, Own>();
  private readonly tabs = new TabCoordinator(
    () => this.mergeTabs(),
    () => this.ownViews(),
  );
  private reportedMs = -Infinity;

  constructor(private readonly api: Api) {
    addEventListener("online", () => {
      for (const [id, own] of this.own) if (this.phase(id) === "stalled") own.running?.resume();
    });
    addEventListener("beforeunload", (event) => {
      if ([...this.uploadViews.value.values()].some(isOpen)) event.preventDefault(); // the browser asks the user whether to leave
    });
    setInterval(() => {
      this.notifyTabs();
      void this.tabs.forgetClosedTabs();
    }, reportedEveryMs);
  }

  get views(): ReadonlySignal<ReadonlyMap<string, UploadView>> {
    return this.uploadViews;
  }

  /**
   * Starts an upload, or resumes an interrupted one of these files. Returns the data set's ID once data can be sent.
   * Rejects with ApiProblem or SentElsewhere.
   */
  async start(files: readonly Blob[], title: string, fingerprint: string): Promise<string> {
    const bundle = makeBundle(files);
    const earlier = await this.resumeRemembered(fingerprint, bundle.size);
    const upload = earlier ?? (await this.create(title, bundle.size, files.length));
    const id = upload.data_set_id;
    rememberUpload(local, fingerprint, upload);
    this.own.set(id, { bundle, url: upload.upload_url, running: null });
    this.show({ ...begun(id, bundle.size), sent: earlier?.received ?? 0 });
    this.sendNext();
    this.tabs.broadcast();
    return id;
  }

  /** Returns the unfinished upload of these files that the server still has. `received` is its offset in bytes. */
  async interrupted(
    fingerprint: string,
    bytes: number,
  ): Promise<(RememberedUpload & { readonly received: number }) | null> {
    const known = rememberedUpload(local, fingerprint);
    if (known?.bytes !== bytes || this.own.has(known.data_set_id)) return null;
    try {
      const { state, upload } = await this.api.dataSet(known.data_set_id);
      return state === "uploading" && upload?.bytes === bytes ? { ...known, received: upload.received_bytes } : null;
    } catch (thrown) {
      if (thrown instanceof ApiProblem && thrown.status === 404) return null; // it was deleted, has expired or belongs to another user
      throw thrown;
    }
  }

  pause(id: string): void {
    this.own.get(id)?.running?.stop();
    this.change(id, (view) => inPhase(view, "paused"));
    this.sendNext();
  }

  resume(id: string): void {
    this.change(id, (view) => inPhase(view, "waiting"));
    this.sendNext();
  }

  /** Stops the upload and deletes it here and on the server. */
  async cancel(id: string): Promise<void> {
    this.drop(id);
    forgetUpload(local, id);
    this.sendNext();
    await this.api.deleteDataSet(id);
  }

  /** Forgets a complete upload, because the list of scans now shows its scan. */
  forgetSent(id: string): void {
    if (this.phase(id) === "sent") this.drop(id);
  }

  /** Stops all uploads, because another user signs in. */
  stopAll(): void {
    for (const id of [...this.own.keys()]) this.drop(id);
    this.uploadViews.value = new Map();
  }

  /** Returns the same as `interrupted`, and makes this window the one that sends the upload. */
  private async resumeRemembered(fingerprint: string, bytes: number): ReturnType<Uploads["interrupted"]> {
    const known = rememberedUpload(local, fingerprint);
    if (known?.bytes !== bytes || this.own.has(known.data_set_id)) return null;
    if (!(await this.tabs.claim(known.data_set_id))) throw new SentElsewhere();
    let found: Awaited<ReturnType<Uploads["interrupted"]>> = null;
    try {
      found = await this.interrupted(fingerprint, bytes);
    } finally {
      if (!found) this.tabs.release(known.data_set_id);
    }
    return found;
  }

  private async create(title: string, bytes: number, slices: number): Promise<RememberedUpload> {
    const made = await this.api.createDataSet(title, bytes, slices, randomKey());
    await this.tabs.claim(made.data_set.id); // no other window knows of the upload yet
    return { data_set_id: made.data_set.id, upload_url: made.upload_url, bytes };
  }

  private sendNext(): void {
    for (;;) {
      const id = nextToSend(this.uploadViews.value.values(), atOnce);
      const own = id === null ? undefined : this.own.get(id);
      if (id === null || !own) return;
      this.change(id, (view) => inPhase(view, "sending"));
      if (own.running) own.running.resume();
      else own.running = this.send(id, own);
    }
  }

  private send(id: string, own: Own): RunningUpload {
    return startUpload(own.bundle, own.url, () => this.api.csrfToken, {
      progress: (sent) => {
        this.change(id, (view) => withProgress(view, sent, performance.now()));
        this.notifyTabs();
      },
      stalled: (by) => this.change(id, (view) => stalled(view, by)),
      end: (end) => {
        if (end.kind === "done") {
          forgetUpload(local, id);
          this.release(id);
          this.change(id, (view) => inPhase({ ...view, sent: view.total }, "sent"));
        } else {
          this.release(id);
          this.change(id, (view) => refused(view, end));
        }
        this.sendNext();
      },
    });
  }

  private phase(id: string): UploadView["phase"] | undefined {
    return this.uploadViews.value.get(id)?.phase;
  }

  private show(view: UploadView): void {
    this.uploadViews.value = new Map(this.uploadViews.value).set(view.data_set_id, view);
  }

  private change(id: string, to: (view: UploadView) => UploadView): void {
    const view = this.uploadViews.value.get(id);
    if (view) this.show(to(view));
  }

  private ownViews(): readonly UploadView[] {
    return [...this.uploadViews.value.values()].filter((view) => isOpen(view) && this.own.has(view.data_set_id));
  }

  /**
   * Reports progress to the other windows. Called by a timer, which browsers throttle in the
   * background, and by arriving data, which wakes the window.
   */
  private notifyTabs(): void {
    if (performance.now() - this.reportedMs < reportedEveryMs / 2) return;
    this.reportedMs = performance.now();
    this.tabs.broadcast();
  }

  private mergeTabs(): void {
    const kept = [...this.uploadViews.value].filter(([, view]) => view.phase !== "elsewhere");
    const others = this.tabs.views().filter((view) => !this.own.has(view.data_set_id));
    if (others.length === 0 && kept.length === this.uploadViews.value.size) return;
    this.uploadViews.value = new Map([
      ...kept,
      ...others.map((view) => [view.data_set_id, inPhase(view, "elsewhere")] as const),
    ]);
  }

  /** Releases the upload, because this window has nothing more to send of it. */
  private release(id: string): void {
    if (this.own.delete(id)) this.tabs.release(id);
  }

  private drop(id: string): void {
    this.own.get(id)?.running?.stop();
    this.release(id);
    const views = new Map(this.uploadViews.value);
    views.delete(id);
    this.uploadViews.value = views;
  }
}
