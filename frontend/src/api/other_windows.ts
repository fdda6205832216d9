import type { UploadView } from "./upload_view";

/**
 * Tells the other windows of this browser which uploads this one sends, so that no two send the same, and a person sees
 * in each how far it is. Nothing leaves the browser.
 */
export class OtherWindows {
  private readonly channel_ = typeof BroadcastChannel === "undefined" ? null : new BroadcastChannel("diaphane.uploads");
  private readonly heard_ = new Map<string, { readonly view: UploadView; readonly at_ms: number }>();

  /** @param changed is called when what the others send has changed. */
  constructor(changed: () => void) {
    if (!this.channel_) return;
    this.channel_.onmessage = (event: MessageEvent<{ sent: readonly UploadView[]; ended: readonly string[] }>) => {
      for (const view of event.data.sent) this.heard_.set(view.data_set_id, { view, at_ms: Date.now() });
      for (const id of event.data.ended) this.heard_.delete(id);
      changed();
    };
  }

  tell(sent: readonly UploadView[], ended: readonly string[] = []): void {
    if (sent.length + ended.length > 0) this.channel_?.postMessage({ sent: sent.map((view) => ({ ...view, marks: [] })), ended });
  }

  /** What was heard of lately: a window that was closed says nothing more. */
  views(): readonly UploadView[] {
    const since = Date.now() - silent_ms;
    return [...this.heard_.values()].filter(({ at_ms }) => at_ms > since).map(({ view }) => view);
  }
}

/** A window in the background may be woken only once a minute; while it sends it is woken by each part. */
const silent_ms = 12_000;
