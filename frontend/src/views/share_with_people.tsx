import { useEffect, useState } from "preact/hooks";
import type { DataSet, Permissions, SharedPerson } from "../api/types";
import { t } from "../texts";
import { Choice } from "./choice";
import { Field } from "./field";
import { IconButton } from "./icon_button";
import { useAct } from "./use_act";
import { Switch } from "./viewer/settings/controls";

type Permission = "view" | "save";

/** The people with an account with whom a scan is shared. */
export function ShareWithPeople({ set }: { readonly set: DataSet }) {
  const { people, busy, outcome, add, change, remove } = useSharedPeople(set.id);
  const text = t.sharing.people;
  return (
    <section class="share-part" aria-label={text.title}>
      <h3>{text.title}</h3>
      <p class="muted">{text.lead}</p>
      <p class="muted">{text.sees}</p>
      {people.length === 0 ? (
        <p>{text.nobody}</p>
      ) : (
        <ul class="people">
          {people.map((one) => (
            <li key={one.id}>
              <span class="people-name">{one.email}</span>
              <small>{text[one.may]}</small>
              <IconButton icon="close" label={text.remove(one.email)} disabled={busy} onClick={() => remove(one)} />
              <div class="people-may" role="group" aria-label={text.mayOf(one.email)}>
                <PermissionSwitches allowed={one} busy={busy} change={(to) => change(one, to)} />
              </div>
            </li>
          ))}
        </ul>
      )}
      {people.length === 0 ? null : <p class="field-hint">{text.changeHint}</p>}
      <AddPerson busy={busy} add={add} />
      {outcome}
    </section>
  );
}

function useSharedPeople(dataSetId: string) {
  const { app, act, busy, outcome } = useAct();
  const [people, setPeople] = useState<readonly SharedPerson[]>([]);
  const text = t.sharing.people;
  useEffect(() => {
    app.api.sharing.people(dataSetId).then(setPeople, () => undefined);
  }, [app, dataSetId]);
  /** Shares the scan with a person. `done` is called when the person has been added. */
  const add = (email: string, may: Permission, allowed: Permissions, done: () => void) =>
    act(async () => {
      await app.api.sharing.shareWith(dataSetId, email, may, allowed);
      setPeople(await app.api.sharing.people(dataSetId));
      done();
      return text.added(email);
    });
  const change = (one: SharedPerson, to: Partial<Permissions>) =>
    act(async () => {
      await app.api.sharing.changePerson(dataSetId, one.id, to);
      setPeople(await app.api.sharing.people(dataSetId));
      return text.changed(one.email);
    });
  const remove = (one: SharedPerson) =>
    act(async () => {
      await app.api.sharing.unshare(dataSetId, one.id);
      setPeople(await app.api.sharing.people(dataSetId));
      return text.removed(one.email);
    });
  return { people, busy, outcome, add, change, remove };
}

interface PermissionSwitchesProps {
  readonly allowed: Permissions;
  readonly busy: boolean;
  readonly change: (to: Partial<Permissions>) => void;
}

function PermissionSwitches({ allowed, busy, change }: PermissionSwitchesProps) {
  const text = t.sharing.people;
  return (
    <>
      <Switch label={text.slices} on={allowed.slices} disabled={busy} change={(slices) => change({ slices })} />
      <Switch
        label={text.downloads}
        on={allowed.downloads}
        disabled={busy}
        change={(downloads) => change({ downloads })}
      />
    </>
  );
}

interface AddPersonProps {
  readonly busy: boolean;
  readonly add: (email: string, may: Permission, allowed: Permissions, done: () => void) => void;
}

function AddPerson({ busy, add }: AddPersonProps) {
  const [email, setEmail] = useState("");
  const [may, setMay] = useState<Permission>("view");
  const [allowed, setAllowed] = useState<Permissions>({ slices: true, downloads: true });
  const text = t.sharing.people;
  return (
    <form
      class="share-form"
      noValidate
      onSubmit={(event) => {
        event.preventDefault();
        add(email.trim(), may, allowed, () => setEmail(""));
      }}
    >
      <Field label={text.email} type="email" value={email} onInput={setEmail} autocomplete="off" most={254} />
      <Choice
        label={text.may}
        value={may}
        onChoose={(value) => setMay(value === "save" ? "save" : "view")}
        options={[
          ["view", text.view],
          ["save", text.save],
        ]}
      />
      <div class="people-may" role="group" aria-label={text.mayNew}>
        <PermissionSwitches allowed={allowed} busy={busy} change={(to) => setAllowed({ ...allowed, ...to })} />
        <p class="field-hint">{t.sharing.downloadsHint}</p>
      </div>
      <button type="submit" class="button" disabled={busy || email.trim() === ""}>
        {text.add}
      </button>
    </form>
  );
}
