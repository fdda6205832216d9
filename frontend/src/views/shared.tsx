import { useEffect, useMemo, useState } from "preact/hooks";
import { ApiProblem } from "../api/client";
import { randomKey } from "../api/random_key";
import type { DataSet } from "../api/types";
import { visitPlace } from "../live/place";
import { tab } from "../storage";
import { t } from "../texts";
import { AccountFrame } from "./account_frame";
import { dateText } from "./format";
import { Link } from "./router";
import { titleOf } from "./scan_card";
import { Notice, Shell } from "./shell";
import { useApp } from "./state";
import { useSamples } from "./use_samples";
import { Viewer } from "./viewer/viewer";

const keyName = (where: string) => `diaphane.visit.${where.slice(0, 8)}`;

/** Identifies the visitor across reloads. Another tab is another visit. */
function visitorKey(where: string): string {
  const known = tab.getItem(keyName(where));
  if (known !== null && /^[0-9a-f]{64}$/.test(known)) return known;
  const key = randomKey() + randomKey();
  tab.setItem(keyName(where), key);
  return key;
}

/** The place of a visit, and a way to begin another visit once it is over. */
function useVisit(what: { readonly token: string } | { readonly data_set_id: string }, where: string) {
  const app = useApp();
  const [key, setKey] = useState(() => visitorKey(where));
  // eslint-disable-next-line react-hooks/exhaustive-deps -- `what` is a new object in each render but always matches `where`
  const place = useMemo(() => visitPlace(app.api, what, key), [app, where, key]);
  const again = () => {
    tab.removeItem(keyName(where));
    setKey(visitorKey(where));
  };
  return { place, again };
}

/** The page behind a link to a scan: first a description, then the picture. It needs no account. */
export function SharedByLink({ token }: { readonly token: string }) {
  const app = useApp();
  const [leads, setLeads] = useState<{ readonly data_set: DataSet; readonly expires_at: string } | null>(null);
  const [fault, setFault] = useState("");
  const [gone, setGone] = useState(false);
  const [looking, setLooking] = useState(false);
  const { place, again } = useVisit({ token }, token);
  useEffect(() => {
    app.api.sharing.follow(token).then(setLeads, (thrown: unknown) => {
      const isGone = thrown instanceof ApiProblem && thrown.status === 404;
      setGone(isGone);
      setFault(isGone ? t.sharing.visit.gone : app.explain(thrown));
    });
  }, [app, token]);
  if (looking && leads)
    return <Viewer key={place.key} place={place} title={titleOf(leads.data_set)} visitor={{ kind: "link", again }} />;
  const text = t.sharing.visit;
  return (
    <Shell>
      <AccountFrame
        title={gone ? text.goneTitle : text.title}
        lead={leads ? text.lead(dateText(leads.expires_at)) : ""}
      >
        {fault ? <Notice kind="bad">{fault}</Notice> : null}
        {gone ? (
          <Link href="/" class="button button-main button-wide">
            {t.toStart}
          </Link>
        ) : null}
        {leads ? (
          <>
            <h2>{titleOf(leads.data_set)}</h2>
            {leads.data_set.description ? <p class="card-description">{leads.data_set.description}</p> : null}
            {leads.data_set.owner_name ? <p class="muted">{text.by(leads.data_set.owner_name)}</p> : null}
            <p class="muted">{t.sharing.views.toldGuest}</p>
            <button type="button" class="button button-main button-wide" onClick={() => setLooking(true)}>
              {text.look}
            </button>
          </>
        ) : null}
        {!leads && !fault ? (
          <p class="muted" role="status">
            {t.loading}
          </p>
        ) : null}
      </AccountFrame>
    </Shell>
  );
}

/** A sample, for visitors without an account. */
export function SharedSample({ dataSetId }: { readonly dataSetId: string }) {
  const { place, again } = useVisit({ data_set_id: dataSetId }, dataSetId);
  const sample = useSamples()?.find(({ id }) => id === dataSetId);
  return (
    <Viewer
      key={place.key}
      place={place}
      title={sample ? titleOf(sample) : t.scans.sampleTitle}
      visitor={{ kind: "sample", again }}
    />
  );
}
