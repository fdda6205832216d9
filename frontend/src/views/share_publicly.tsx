import { useEffect, useState } from "preact/hooks";
import type { DataSet, Permissions } from "../api/types";
import { t } from "../texts";
import { Field } from "./field";
import { Link } from "./router";
import { Notice } from "./shell";
import { useAct } from "./use_act";
import { Switch } from "./viewer/settings/controls";

export interface SharePubliclyProps {
  readonly set: DataSet;
  readonly onChange: (set: DataSet) => void;
}

/** Makes a scan public, which is possible once it has been anonymised. */
export function SharePublicly({ set, onChange }: SharePubliclyProps) {
  const { name, setName, allowed, busy, outcome, publish, allow, hide } = usePublication(set, onChange);
  const text = t.sharing.everybody;
  return (
    <section class="share-part" aria-label={text.title}>
      <h3>{text.title}</h3>
      <p class="muted">{text.lead}</p>
      <p class="muted">{text.sees}</p>
      {set.anonymised_at === null ? (
        <AnonymiseFirst set={set} />
      ) : (
        <>
          <Field
            label={text.name}
            value={name}
            onInput={setName}
            autocomplete="nickname"
            hint={text.nameHint}
            most={40}
          />
          <Switch
            label={text.slices}
            on={allowed.slices}
            disabled={busy}
            change={(slices) => allow({ ...allowed, slices }, slices ? text.slicesShown : text.slicesHidden)}
          />
          <p class="field-hint">{text.slicesHint}</p>
          <Switch
            label={t.sharing.downloads}
            on={allowed.downloads}
            disabled={busy}
            change={(downloads) =>
              allow({ ...allowed, downloads }, downloads ? text.downloadsAllowed : text.downloadsEnded)
            }
          />
          <p class="field-hint">{t.sharing.downloadsHint}</p>
          <p>
            {set.is_public ? (
              <button type="button" class="button button-danger" disabled={busy} onClick={hide}>
                {text.hide}
              </button>
            ) : (
              <button type="button" class="button button-main" disabled={busy} onClick={publish}>
                {text.publish}
              </button>
            )}
          </p>
        </>
      )}
      {outcome}
    </section>
  );
}

function AnonymiseFirst({ set }: { readonly set: DataSet }) {
  return (
    <>
      <Notice kind="info">{t.sharing.everybody.firstCut}</Notice>
      <p>
        <Link href={`/cut/${set.id}`} class="button button-main">
          {t.sharing.everybody.cut}
        </Link>
      </p>
    </>
  );
}

/** The public name of the owner, what everyone may do, and the actions that change the visibility. */
function usePublication(set: DataSet, onChange: (set: DataSet) => void) {
  const { app, act, busy, outcome } = useAct();
  const [name, setName] = useState("");
  const [allowed, setAllowed] = useState<Permissions>({
    slices: set.public_slices,
    downloads: set.public_downloads,
  });
  const text = t.sharing.everybody;
  useEffect(() => {
    app.api.sharing.publicName().then(setName, () => undefined);
  }, [app]);
  const publish = () =>
    act(async () => {
      await app.api.sharing.setPublicName(name.trim());
      onChange(await app.api.sharing.setVisibility(set.id, "public", allowed));
      return text.isPublic;
    });
  /** Changes what everyone may do, at once if the scan is public. Then shows the text `done`. */
  const allow = (to: Permissions, done: string) => {
    setAllowed(to);
    if (!set.is_public) return;
    act(async () => {
      try {
        onChange(await app.api.sharing.setVisibility(set.id, "public", to));
      } catch (thrown) {
        setAllowed(allowed); // the switch shows what still applies
        throw thrown;
      }
      return done;
    });
  };
  const hide = () =>
    act(async () => {
      onChange(await app.api.sharing.setVisibility(set.id, "private"));
      return text.isPrivate;
    });
  return { name, setName, allowed, busy, outcome, publish, allow, hide };
}
