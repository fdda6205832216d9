import { useEffect, useState } from "preact/hooks";
import type { DataSet } from "../api/types";
import { is_open, type UploadView } from "../api/upload_view";
import { t } from "../texts";
import { Dialog } from "./dialog";
import { bytes_text } from "./format";
import { Icon } from "./icons";
import { Link } from "./router";
import { ScanCard, title_of } from "./scan_card";
import { Notice, PageTitle, use_focus_kept } from "./shell";
import { useApp } from "./state";
import { use_warm_thumbnails } from "./thumbnail";

/** So many of the newest are made ready to be opened. */
const warmed = 4;

export function Scans() {
  const app = useApp();
  const [sets, set_sets] = useState<readonly DataSet[] | null>(null);
  const [fault, set_fault] = useState("");
  const [removing, set_removing] = useState<DataSet | null>(null);
  const [round, set_round] = useState(0);
  const uploads = app.uploads.views.value;
  const open = [...uploads.values()].filter(is_open).length;
  use_focus_kept(sets?.length);

  useEffect(() => {
    const leaving = new AbortController();
    let timer: ReturnType<typeof setTimeout> | undefined;
    const load = async (): Promise<void> => {
      let wait = 15_000;
      try {
        const [found, me] = await Promise.all([app.api.data_sets(leaving.signal), app.api.me()]);
        if (leaving.signal.aborted) return;
        set_sets(found);
        app.me.value = me;
        set_fault("");
        for (const set of found) if (set.state !== "uploading") app.uploads.forget_sent(set.id);
        const moves = (set: DataSet) => set.state === "queued" || set.state === "building" || app.uploads.views.peek().has(set.id);
        if (found.some(moves)) wait = 1500;
      } catch (thrown) {
        if (leaving.signal.aborted) return;
        set_fault(app.explain(thrown));
        wait = 3000;
      }
      timer = setTimeout(() => void load(), wait);
    };
    void load();
    return () => {
      leaving.abort();
      clearTimeout(timer);
    };
    // An upload that ends changes the list at once.
  }, [app, round, open]);

  const remove = async (set: DataSet) => {
    set_removing(null);
    try {
      await app.uploads.cancel(set.id);
    } catch (thrown) {
      set_fault(app.explain(thrown));
    }
    set_round(round + 1);
  };

  const quota = app.me.value?.quota;
  return (
    <div class="page">
      <div class="page-head">
        <div>
          <PageTitle text={t.titles.scans} />
          {quota && quota.bytes > 0 ? (
            <div class="quota">
              <meter min={0} max={quota.bytes} value={quota.used_bytes} aria-hidden="true" />
              <span>{t.scans.used(bytes_text(quota.used_bytes), bytes_text(quota.bytes))}</span>
            </div>
          ) : null}
        </div>
        <Link href="/add" class="button button-main"><Icon name="plus" />{t.scans.add}</Link>
      </div>
      {fault ? <Notice kind="bad">{fault}</Notice> : null}
      {sets === null && !fault ? <p class="muted" role="status">{t.loading}</p> : null}
      {sets ? <List sets={sets} uploads={uploads} onRemove={set_removing} /> : null}
      {removing ? (
        <RemoveDialog
          set={removing}
          uploading={removing.state === "uploading"}
          onNo={() => set_removing(null)}
          onYes={() => void remove(removing)}
        />
      ) : null}
    </div>
  );
}

interface RemoveDialogProps {
  readonly set: DataSet;
  readonly uploading: boolean;
  readonly onNo: () => void;
  readonly onYes: () => void;
}

function RemoveDialog({ set, uploading, onNo, onYes }: RemoveDialogProps) {
  const text = t.scans;
  return (
    <Dialog title={uploading ? text.cancel_title : text.remove_title} onClose={onNo}>
      <p>{uploading ? text.cancel_text(title_of(set)) : text.remove_text(title_of(set))}</p>
      <div class="dialog-buttons">
        <button type="button" class="button" onClick={onNo}>{uploading ? text.cancel_no : t.cancel}</button>
        <button type="button" class="button button-danger" onClick={onYes}>{uploading ? text.cancel_yes : text.remove_yes}</button>
      </div>
    </Dialog>
  );
}

interface ListProps {
  readonly sets: readonly DataSet[];
  readonly uploads: ReadonlyMap<string, UploadView>;
  readonly onRemove: (set: DataSet) => void;
}

function List({ sets, uploads, onRemove }: ListProps) {
  use_warm_thumbnails(sets.filter((set) => set.state === "ready").slice(0, warmed).map((set) => set.id));
  const own = sets.filter((set) => set.owned);
  const shared = sets.filter((set) => !set.owned && !set.is_sample);
  const samples = sets.filter((set) => !set.owned && set.is_sample);
  const card = (set: DataSet) => (
    <li key={set.id}>
      <ScanCard set={set} upload={uploads.get(set.id) ?? null} onRemove={() => onRemove(set)} />
    </li>
  );
  return (
    <>
      {own.length === 0 ? (
        <section class="empty">
          <Icon name="folder" />
          <h2>{t.scans.empty}</h2>
          <p>{t.scans.lead_empty}</p>
          <Link href="/add" class="button button-main">{t.scans.add}</Link>
        </section>
      ) : (
        <section>
          <h2 class="visually-hidden">{t.scans.list}</h2>
          <ul class="cards">{own.map(card)}</ul>
        </section>
      )}
      {shared.length > 0 ? (
        <section class="others">
          <h2>{t.sharing.with_me}</h2>
          <ul class="cards">{shared.map(card)}</ul>
        </section>
      ) : null}
      {samples.length > 0 ? (
        <section class="others">
          <h2>{t.scans.examples}</h2>
          <ul class="cards">{samples.map(card)}</ul>
        </section>
      ) : null}
    </>
  );
}
