import { useState } from "preact/hooks";
import type { ViewEntry } from "../api/types";
import { t } from "../texts";
import { CloseButton, Dialog } from "./dialog";
import { dateText, dayShortText } from "./format";
import { Loading } from "./loading";
import { MoreButton } from "./more_button";
import { Notice } from "./shell";
import { useApp } from "./state";
import { usePages } from "./use_pages";

export interface ViewLogProps {
  readonly dataSetId: string;
  readonly onClose: () => void;
}

/** Who viewed a scan, for its owner. Their own views are hidden until they ask for them. */
export function ViewLogDialog({ dataSetId, onClose }: ViewLogProps) {
  const [own, setOwn] = useState(false);
  const text = t.sharing.views;
  return (
    <Dialog title={text.title} onClose={onClose}>
      <p class="muted">{text.lead}</p>
      <label class="view-log-own">
        <input type="checkbox" checked={own} onChange={(event) => setOwn(event.currentTarget.checked)} />
        <span>{text.own}</span>
      </label>
      <Entries key={String(own)} dataSetId={dataSetId} own={own} />
      <CloseButton onClick={onClose} />
    </Dialog>
  );
}

function Entries({ dataSetId, own }: { readonly dataSetId: string; readonly own: boolean }) {
  const app = useApp();
  const { items, next, wrong, more } = usePages((cursor) => app.api.sharing.views(dataSetId, own, cursor));
  const text = t.sharing.views;
  return (
    <>
      {wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {items === null && !wrong ? <Loading /> : null}
      {items?.length === 0 ? <p role="status">{own ? text.nobody : text.nobodyElse}</p> : null}
      {items && items.length > 0 ? (
        <ul class="view-log" aria-label={text.title}>
          {items.map((entry) => (
            <Entry key={entry.id} entry={entry} />
          ))}
        </ul>
      ) : null}
      {next ? <MoreButton onClick={more} /> : null}
    </>
  );
}

function Entry({ entry }: { readonly entry: ViewEntry }) {
  const text = t.sharing.views;
  const browser = text.browser(entry.browser || t.myAccount.aBrowser);
  return (
    <li data-route={entry.route}>
      <strong>{viewerOf(entry)}</strong>
      <span>
        <time dateTime={entry.last_at}>{dateText(entry.last_at)}</time>
        {entry.times > 1 ? ` · ${text.times(entry.times, dateText(entry.first_at))}` : ""}
      </span>
      <small>{[browser, networkOf(entry)].filter(Boolean).join(" · ")}</small>
    </li>
  );
}

function viewerOf({ route, email, link_created_at: linkCreatedAt }: ViewEntry): string {
  const text = t.sharing.views;
  if (route === "person") return email ?? text.gone;
  if (route === "link" && linkCreatedAt !== null) return text.link(dayShortText(linkCreatedAt));
  return text.routes[route];
}

/**
 * Returns a text for the network. The start of its address says little, so the owner's own network
 * is named as such.
 */
function networkOf({ network, same_network: same }: ViewEntry): string {
  if (same) return t.sharing.views.sameNetwork;
  return network === "" ? "" : t.sharing.views.network(network.replace(/\.0\.0\/16$|:?:\/32$/, "…"));
}
