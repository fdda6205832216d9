import { useEffect, useId, useState } from "preact/hooks";
import { body_parts, type DataSet, type DataSetLink, type SharedPerson } from "../api/types";
import { t } from "../texts";
import { Choice } from "./choice";
import { Dialog } from "./dialog";
import { Field } from "./field";
import { date_text } from "./format";
import { Icon } from "./icons";
import { Link } from "./router";
import { Notice } from "./shell";
import { useApp } from "./state";
import { Switch } from "./viewer/settings/controls";

export interface ShareScanProps {
  readonly set: DataSet;
  readonly onChange: (set: DataSet) => void;
  readonly onClose: () => void;
}

interface PartProps {
  readonly set: DataSet;
  readonly onChange: (set: DataSet) => void;
}

/** What its owner says of a scan, and who else may see it. */
export function ShareScanDialog({ set, onChange, onClose }: ShareScanProps) {
  return (
    <Dialog title={t.sharing.title} onClose={onClose}>
      <p class="muted">{t.sharing.lead}</p>
      {set.taken_down ? <Notice kind="bad">{t.sharing.everybody.taken_down(set.taken_down.reason)}</Notice> : null}
      <Details set={set} onChange={onChange} />
      {set.taken_down ? null : (
        <>
          <People set={set} />
          <Links set={set} />
          <Everybody set={set} onChange={onChange} />
        </>
      )}
      <div class="dialog-buttons">
        <button type="button" class="button button-main" onClick={onClose}>{t.close}</button>
      </div>
    </Dialog>
  );
}

/** Runs what a person asked for, says how it went. */
function use_act() {
  const app = useApp();
  const [said, set_said] = useState("");
  const [fault, set_fault] = useState("");
  const [busy, set_busy] = useState(false);
  const act = (work: () => Promise<string>) => {
    set_busy(true);
    set_said("");
    set_fault("");
    work().then(set_said, (thrown: unknown) => set_fault(app.explain(thrown))).finally(() => set_busy(false));
  };
  const outcome = (
    <>
      <p class="muted" role="status">{said}</p>
      {fault ? <Notice kind="bad">{fault}</Notice> : null}
    </>
  );
  return { app, act, busy, outcome };
}

function Details({ set, onChange }: PartProps) {
  const { app, act, busy, outcome } = use_act();
  const id = useId();
  const [title, set_title] = useState(set.title);
  const [description, set_description] = useState(set.description);
  const [body_part, set_body_part] = useState<string>(set.body_part ?? "");
  const text = t.sharing.details;
  const save = () => act(async () => {
    onChange(await app.api.sharing.describe(set.id, { title, description, body_part: body_part || null }));
    return text.saved;
  });
  return (
    <section class="share-part" aria-label={text.title}>
      <h3>{text.title}</h3>
      <Field label={text.name} value={title} onInput={set_title} most={80} hint={text.name_hint} />
      <div class="field">
        <label for={`${id}-text`}>{text.text}</label>
        <textarea id={`${id}-text`} class="prose" rows={3} maxLength={2000} value={description} onInput={(event) => set_description(event.currentTarget.value)} aria-describedby={`${id}-hint`} />
        <p class="field-hint" id={`${id}-hint`}>{text.text_hint}</p>
      </div>
      <Choice label={text.body_part} value={body_part} onChoose={set_body_part}
        options={[["", text.none], ...body_parts.map((part): [string, string] => [part, t.sharing.parts[part] ?? part])]} />
      <p><button type="button" class="button" disabled={busy} onClick={save}>{text.save}</button></p>
      {outcome}
    </section>
  );
}

function People({ set }: { readonly set: DataSet }) {
  const { app, act, busy, outcome } = use_act();
  const [people, set_people] = useState<readonly SharedPerson[]>([]);
  const [email, set_email] = useState("");
  const [may, set_may] = useState<"view" | "save">("view");
  const text = t.sharing.people;
  useEffect(() => {
    app.api.sharing.people(set.id).then(set_people, () => undefined);
  }, [app, set.id]);
  const add = () => act(async () => {
    await app.api.sharing.share_with(set.id, email.trim(), may);
    set_people(await app.api.sharing.people(set.id));
    set_email("");
    return text.added(email.trim());
  });
  const remove = (one: SharedPerson) => act(async () => {
    await app.api.sharing.unshare(set.id, one.id);
    set_people(await app.api.sharing.people(set.id));
    return text.removed(one.email);
  });
  return (
    <section class="share-part" aria-label={text.title}>
      <h3>{text.title}</h3>
      <p class="muted">{text.lead}</p>
      {people.length === 0 ? <p>{text.nobody}</p> : (
        <ul class="people">
          {people.map((one) => (
            <li key={one.id}>
              <span class="people-name">{one.email}</span>
              <small>{text[one.may]}</small>
              <button type="button" class="icon-button" disabled={busy} aria-label={text.remove(one.email)} title={text.remove(one.email)} onClick={() => remove(one)}><Icon name="close" /></button>
            </li>
          ))}
        </ul>
      )}
      <form class="share-form" noValidate onSubmit={(event) => {
        event.preventDefault();
        add();
      }}>
        <Field label={text.email} type="email" value={email} onInput={set_email} autocomplete="off" most={254} />
        <Choice label={text.may} value={may} onChoose={(value) => set_may(value === "save" ? "save" : "view")} options={[["view", text.view], ["save", text.save]]} />
        <button type="submit" class="button" disabled={busy || email.trim() === ""}>{text.add}</button>
      </form>
      {outcome}
    </section>
  );
}

function Links({ set }: { readonly set: DataSet }) {
  const { app, act, busy, outcome } = use_act();
  const [links, set_links] = useState<readonly DataSetLink[]>([]);
  const [made, set_made] = useState("");
  const [hours, set_hours] = useState("168");
  const [slices, set_slices] = useState(false);
  const text = t.sharing.links;
  useEffect(() => {
    app.api.sharing.links(set.id).then(set_links, () => undefined);
  }, [app, set.id]);
  const make = () => act(async () => {
    const link = await app.api.sharing.make_link(set.id, Number(hours), slices);
    set_made(location.origin + link.path);
    set_links(await app.api.sharing.links(set.id));
    return text.new_link;
  });
  const end = (link: DataSetLink) => act(async () => {
    await app.api.sharing.end_link(set.id, link.id);
    set_made("");
    set_links(await app.api.sharing.links(set.id));
    return text.ended;
  });
  const copy = () => act(async () => {
    await navigator.clipboard.writeText(made);
    return text.copied;
  });
  return (
    <section class="share-part" aria-label={text.title}>
      <h3>{text.title}</h3>
      <p class="muted">{text.lead}</p>
      {links.length === 0 ? <p>{text.none}</p> : (
        <ul class="people">
          {links.map((link) => (
            <li key={link.id}>
              <span class="people-name">{text.until(date_text(link.expires_at))}</span>
              {link.slices ? <small>{text.with_slices}</small> : null}
              <button type="button" class="button button-small" disabled={busy} aria-label={text.end_of(date_text(link.expires_at))} onClick={() => end(link)}>{text.end}</button>
            </li>
          ))}
        </ul>
      )}
      {made ? (
        <div class="share-row">
          <input type="text" readOnly value={made} aria-label={text.new_link} onFocus={(event) => event.currentTarget.select()} />
          <button type="button" class="button" onClick={copy}><Icon name="copy" />{text.copy}</button>
        </div>
      ) : null}
      <div class="share-form">
        <Choice label={text.life} value={hours} onChoose={set_hours} options={Object.entries(text.lives)} />
        <button type="button" class="button" disabled={busy} onClick={make}>{text.make}</button>
      </div>
      <Switch label={text.slices} on={slices} change={set_slices} />
      <p class="field-hint">{text.slices_hint}</p>
      {outcome}
    </section>
  );
}

function Everybody({ set, onChange }: PartProps) {
  const { app, act, busy, outcome } = use_act();
  const [name, set_name] = useState("");
  const [slices, set_slices] = useState(set.public_slices);
  const text = t.sharing.everybody;
  useEffect(() => {
    app.api.sharing.public_name().then(set_name, () => undefined);
  }, [app]);
  const publish = () => act(async () => {
    await app.api.sharing.set_public_name(name.trim());
    onChange(await app.api.sharing.set_visibility(set.id, "public", slices));
    return text.is_public;
  });
  const show_slices = (on: boolean) => {
    set_slices(on);
    if (!set.is_public) return;
    act(async () => {
      onChange(await app.api.sharing.set_visibility(set.id, "public", on));
      return on ? text.slices_shown : text.slices_hidden;
    });
  };
  const hide = () => act(async () => {
    onChange(await app.api.sharing.set_visibility(set.id, "private"));
    return text.is_private;
  });
  return (
    <section class="share-part" aria-label={text.title}>
      <h3>{text.title}</h3>
      <p class="muted">{text.lead}</p>
      {set.anonymised_at === null ? (
        <>
          <Notice kind="info">{text.first_cut}</Notice>
          <p><Link href={`/cut/${set.id}`} class="button button-main">{text.cut}</Link></p>
        </>
      ) : (
        <>
          <Field label={text.name} value={name} onInput={set_name} autocomplete="nickname" hint={text.name_hint} most={40} />
          <Switch label={text.slices} on={slices} disabled={busy} change={show_slices} />
          <p class="field-hint">{text.slices_hint}</p>
          <p>
            {set.is_public
              ? <button type="button" class="button button-danger" disabled={busy} onClick={hide}>{text.hide}</button>
              : <button type="button" class="button button-main" disabled={busy} onClick={publish}>{text.publish}</button>}
          </p>
        </>
      )}
      {outcome}
    </section>
  );
}
