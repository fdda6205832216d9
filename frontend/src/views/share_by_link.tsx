import { useEffect, useState } from "preact/hooks";
import type { DataSet, DataSetLink, Permissions } from "../api/types";
import { t } from "../texts";
import { Choice } from "./choice";
import { CopyField } from "./copy_field";
import { dateText } from "./format";
import { UserError } from "./state";
import { useAct } from "./use_act";
import { Switch } from "./viewer/settings/controls";

/** The links through which people without an account can view a scan. */
export function ShareByLink({ set }: { readonly set: DataSet }) {
  const { links, made, busy, outcome, make, another, end, copy } = useLinks(set.id);
  const text = t.sharing.links;
  return (
    <section class="share-part" aria-label={text.title}>
      <h3>{text.title}</h3>
      <p class="muted">{text.lead}</p>
      <p class="muted">{text.sees}</p>
      {links.length === 0 ? <p>{text.none}</p> : <LinkList links={links} busy={busy} end={end} />}
      {made ? (
        <>
          <CopyField value={made} label={text.newLink} button={text.copy} onCopy={copy} />
          {outcome}
          <p>
            <button type="button" class="button" onClick={another}>
              {text.another}
            </button>
          </p>
        </>
      ) : (
        <>
          {outcome}
          <NewLink busy={busy} make={make} />
        </>
      )}
    </section>
  );
}

interface NewLinkProps {
  readonly busy: boolean;
  readonly make: (hours: number, allowed: Permissions) => void;
}

/** What the next link permits, and for how long. */
function NewLink({ busy, make }: NewLinkProps) {
  const [hours, setHours] = useState("168");
  const [allowed, setAllowed] = useState<Permissions>({ slices: false, downloads: false });
  const text = t.sharing.links;
  return (
    <>
      <Switch label={text.slices} on={allowed.slices} change={(slices) => setAllowed({ ...allowed, slices })} />
      <p class="field-hint">{text.slicesHint}</p>
      <Switch
        label={t.sharing.downloads}
        on={allowed.downloads}
        change={(downloads) => setAllowed({ ...allowed, downloads })}
      />
      <p class="field-hint">{t.sharing.downloadsHint}</p>
      <p class="field-hint">{text.changeHint}</p>
      <div class="share-form">
        <Choice label={text.life} value={hours} onChoose={setHours} options={Object.entries(text.lives)} />
        <button type="button" class="button" disabled={busy} onClick={() => make(Number(hours), allowed)}>
          {text.make}
        </button>
      </div>
    </>
  );
}

/** The links of a scan. `made` is the URL of a new link, which the server cannot show again. */
function useLinks(dataSetId: string) {
  const { app, act, busy, outcome } = useAct();
  const [links, setLinks] = useState<readonly DataSetLink[]>([]);
  const [made, setMade] = useState("");
  const text = t.sharing.links;
  useEffect(() => {
    app.api.sharing.links(dataSetId).then(setLinks, () => undefined);
  }, [app, dataSetId]);
  const make = (hours: number, allowed: Permissions) =>
    act(async () => {
      const link = await app.api.sharing.makeLink(dataSetId, hours, allowed);
      setMade(location.origin + link.path);
      setLinks(await app.api.sharing.links(dataSetId));
      return text.newLink;
    });
  const end = (link: DataSetLink) =>
    act(async () => {
      await app.api.sharing.endLink(dataSetId, link.id);
      setMade("");
      setLinks(await app.api.sharing.links(dataSetId));
      return text.ended;
    });
  const copy = () =>
    act(async () => {
      await navigator.clipboard.writeText(made).catch(() => {
        throw new UserError(text.copyFailed);
      });
      return text.copied;
    });
  const another = () =>
    act(() => {
      setMade("");
      return Promise.resolve("");
    });
  return { links, made, busy, outcome, make, another, end, copy };
}

interface LinkListProps {
  readonly links: readonly DataSetLink[];
  readonly busy: boolean;
  readonly end: (link: DataSetLink) => void;
}

function LinkList({ links, busy, end }: LinkListProps) {
  const text = t.sharing.links;
  return (
    <ul class="people">
      {links.map((link) => (
        <li key={link.id}>
          <span class="people-name">{text.until(dateText(link.expires_at))}</span>
          <small>
            {[link.slices ? text.withSlices : "", link.downloads ? text.withDownloads : ""].filter(Boolean).join(", ")}
          </small>
          <button
            type="button"
            class="button button-small"
            disabled={busy}
            aria-label={text.endOf(dateText(link.expires_at))}
            onClick={() => end(link)}
          >
            {text.end}
          </button>
        </li>
      ))}
    </ul>
  );
}
