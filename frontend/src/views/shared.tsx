import { useEffect, useMemo, useState } from "preact/hooks";
import { ApiProblem } from "../api/client";
import { random_key } from "../api/random_key";
import type { DataSet } from "../api/types";
import { visit_place } from "../live/place";
import { tab } from "../storage";
import { t } from "../texts";
import { AccountFrame } from "./account_frame";
import { date_text } from "./format";
import { title_of } from "./scan_card";
import { Notice, Shell } from "./shell";
import { useApp } from "./state";
import { Viewer } from "./viewer/viewer";

/** The same visitor after a reload; another tab is another visit. */
function visitor_key(where: string): string {
  const name = `diaphane.visit.${where.slice(0, 8)}`;
  const known = tab.getItem(name);
  if (known !== null && /^[0-9a-f]{64}$/.test(known)) return known;
  const key = random_key() + random_key();
  tab.setItem(name, key);
  return key;
}

/** Where a link to a scan leads: what it is, and then the picture. No account is needed. */
export function SharedByLink({ token }: { readonly token: string }) {
  const app = useApp();
  const [leads, set_leads] = useState<{ readonly data_set: DataSet; readonly expires_at: string } | null>(null);
  const [fault, set_fault] = useState("");
  const [looking, set_looking] = useState(false);
  const place = useMemo(() => visit_place(app.api, { token }, visitor_key(token)), [app, token]);
  useEffect(() => {
    app.api.sharing.follow(token).then(set_leads, (thrown: unknown) => {
      set_fault(thrown instanceof ApiProblem && thrown.status === 404 ? t.sharing.visit.gone : app.explain(thrown));
    });
  }, [app, token]);
  if (looking && leads) return <Viewer place={place} title={title_of(leads.data_set)} />;
  const text = t.sharing.visit;
  return (
    <Shell>
      <AccountFrame title={text.title} lead={leads ? text.lead(date_text(leads.expires_at)) : ""}>
        {fault ? <Notice kind="bad">{fault}</Notice> : null}
        {leads ? (
          <>
            <h2>{title_of(leads.data_set)}</h2>
            {leads.data_set.description ? <p class="card-description">{leads.data_set.description}</p> : null}
            {leads.data_set.owner_name ? <p class="muted">{text.by(leads.data_set.owner_name)}</p> : null}
            <button type="button" class="button button-main button-wide" onClick={() => set_looking(true)}>{text.look}</button>
          </>
        ) : null}
        {!leads && !fault ? <p class="muted" role="status">{t.loading}</p> : null}
      </AccountFrame>
    </Shell>
  );
}

/** A sample, before one has an account. */
export function SharedSample({ data_set_id }: { readonly data_set_id: string }) {
  const app = useApp();
  const [looking, set_looking] = useState(false);
  const place = useMemo(() => visit_place(app.api, { data_set_id }, visitor_key(data_set_id)), [app, data_set_id]);
  if (looking) return <Viewer place={place} title={t.scans.sample_title} />;
  return (
    <Shell>
      <AccountFrame title={t.sharing.visit.sample_title} lead={t.sharing.visit.sample_lead}>
        <button type="button" class="button button-main button-wide" onClick={() => set_looking(true)}>{t.sharing.visit.look}</button>
      </AccountFrame>
    </Shell>
  );
}
