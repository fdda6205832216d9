import { useEffect, useState } from "preact/hooks";
import type { DataSet } from "../api/types";
import type { UploadView } from "../api/uploads";
import { t } from "../texts/en";
import { Dialog } from "./dialog";
import { bytes_text } from "./format";
import { Icon } from "./icons";
import { Link } from "./router";
import { ScanCard, title_of } from "./scan_card";
import { Notice, PageTitle } from "./shell";
import { useApp } from "./state";
import { use_warm_thumbnails } from "./thumbnail";

/** So many of the newest are made ready to be opened. */
const warmed = 4;

const busy_states = new Set(["uploading", "queued", "building"]);

export function Scans() {
  const app = useApp();
  const [sets, set_sets] = useState<readonly DataSet[] | null>(null);
  const [fault, set_fault] = useState("");
  const [removing, set_removing] = useState<DataSet | null>(null);
  const [round, set_round] = useState(0);
  const uploads = app.uploads.views.value;

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
        if (found.some((set) => busy_states.has(set.state))) wait = 1500;
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
  }, [app, round, uploads.size]);

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
        <Dialog title={t.scans.remove_title} onClose={() => set_removing(null)}>
          <p>{t.scans.remove_text(title_of(removing))}</p>
          <div class="dialog-buttons">
            <button type="button" class="button" onClick={() => set_removing(null)}>{t.cancel}</button>
            <button type="button" class="button button-danger" onClick={() => void remove(removing)}>{t.scans.remove_yes}</button>
          </div>
        </Dialog>
      ) : null}
    </div>
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
  const others = sets.filter((set) => !set.owned);
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
        <ul class="cards" aria-label={t.scans.list}>{own.map(card)}</ul>
      )}
      {others.length > 0 ? (
        <section class="others">
          <h2>{t.scans.examples}</h2>
          <ul class="cards">{others.map(card)}</ul>
        </section>
      ) : null}
    </>
  );
}
