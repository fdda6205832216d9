import { useEffect, useState, useId } from "preact/hooks";
import { tokenScopes, type ApiToken, type NewApiToken, type TokenScope } from "../api/api_tokens";
import { ApiProblem } from "../api/client";
import { t } from "../texts";
import { problemText } from "../texts/problem_text";
import { Choice } from "./choice";
import { CodeField } from "./code_field";
import { CopyField } from "./copy_field";
import { CurrentPassword, Field } from "./field";
import { Form, fault, faultsOf, type Faults } from "./form";
import { dateText, dayText } from "./format";
import { Loading } from "./loading";
import { Notice, useFocusKept } from "./shell";
import { useApp } from "./state";

type Given = "name" | "scopes" | "password" | "code";
const longestName = 60;
const mostTokens = 20;

/**
 * The panel of the account page for API tokens. `coded`: the account has a second factor, so a new
 * token requires a code.
 */
export function ApiTokens({ coded }: { readonly coded: boolean }) {
  const { items, wrong, made, setMade, load, revoke } = useTokens();
  const [asking, setAsking] = useState(false);
  useFocusKept(items?.length);
  const text = t.apiTokens;
  return (
    <section class="panel" aria-labelledby="api-tokens">
      <h2 id="api-tokens">{text.title}</h2>
      <p class="muted">{text.about}</p>
      {wrong ? <Notice kind="bad">{wrong}</Notice> : null}
      {items === null && !wrong ? <Loading /> : null}
      {made ? <NewToken token={made.token} onKept={() => setMade(null)} /> : null}
      {items?.length === 0 ? <p>{text.none}</p> : null}
      <ul class="rows">
        {(items ?? []).map((one) => (
          <TokenRow key={one.id} token={one} revoke={() => revoke(one)} />
        ))}
      </ul>
      {items && items.length >= mostTokens ? <p>{text.full}</p> : null}
      {asking ? (
        <>
          <CreateToken
            coded={coded}
            onDone={(token) => {
              setAsking(false);
              setMade(token);
              load();
            }}
          />
          <p>
            <button type="button" class="button" onClick={() => setAsking(false)}>
              {t.cancel}
            </button>
          </p>
        </>
      ) : null}
      {!asking && !made && items && items.length < mostTokens ? (
        <p>
          <button type="button" class="button" onClick={() => setAsking(true)}>
            {text.ask}
          </button>
        </p>
      ) : null}
    </section>
  );
}

/** The user's tokens. `made` is a new one until the user has saved its text. */
function useTokens() {
  const app = useApp();
  const [items, setItems] = useState<readonly ApiToken[] | null>(null);
  const [wrong, setWrong] = useState("");
  const [made, setMade] = useState<NewApiToken | null>(null);
  const explain = (thrown: unknown) => setWrong(app.explain(thrown));
  const load = () => {
    app.api.tokens.list().then(setItems, (thrown: unknown) => setWrong(app.explain(thrown)));
  };
  useEffect(load, [app]);
  const revoke = (token: ApiToken) => {
    if (token.id === made?.id) setMade(null);
    setWrong("");
    app.api.tokens.revoke(token.id).then(load, explain);
  };
  return { items, wrong, made, setMade, load, revoke };
}

function TokenRow({ token, revoke }: { readonly token: ApiToken; readonly revoke: () => void }) {
  const text = t.apiTokens;
  const used = token.used_at === null ? text.unused : text.used(dateText(token.used_at));
  return (
    <li>
      <span>
        <strong>{token.name}</strong>
        <span class="muted row-more">{token.scopes.map((scope) => text.scopes[scope]).join("; ")}</span>
        <span class="muted row-more">
          {text.until(dayText(token.expires_at))}, {used}
        </span>
      </span>
      <button type="button" class="button button-small" aria-label={text.revokeOne(token.name)} onClick={revoke}>
        {text.revoke}
      </button>
    </li>
  );
}

function NewToken({ token, onKept }: { readonly token: string; readonly onKept: () => void }) {
  const [told, setTold] = useState("");
  const text = t.apiTokens;
  const copy = () => {
    navigator.clipboard.writeText(token).then(
      () => setTold(text.copied),
      () => setTold(text.copyFailed),
    );
  };
  return (
    <div class="new-token">
      <Notice kind="good">{text.newToken}</Notice>
      <CopyField value={token} label={text.tokenText} button={text.copy} onCopy={copy} />
      <p role="status">{told}</p>
      <p>
        <button type="button" class="button button-main" onClick={onKept}>
          {text.kept}
        </button>
      </p>
    </div>
  );
}

interface CreateProps {
  readonly coded: boolean;
  readonly onDone: (token: NewApiToken) => void;
}

function CreateToken({ coded, onDone }: CreateProps) {
  const made = useCreate(coded, onDone);
  const scopesFault = useId();
  const text = t.apiTokens;
  return (
    <Form onSubmit={made.submit} busy={made.busy} label={text.create} {...fault(made.faults.form)}>
      <Field
        label={text.name}
        hint={text.nameHint}
        value={made.name}
        onInput={made.setName}
        most={longestName}
        {...fault(made.faults.name)}
      />
      <fieldset class="token-scopes">
        <legend>{text.may}</legend>
        {tokenScopes.map((scope) => (
          <label key={scope}>
            <input
              type="checkbox"
              checked={made.scopes.includes(scope)}
              aria-invalid={made.faults.scopes ? true : undefined}
              aria-describedby={made.faults.scopes ? scopesFault : undefined}
              onChange={(event) => made.choose(scope, event.currentTarget.checked)}
            />
            {text.scopes[scope]}
          </label>
        ))}
        {made.faults.scopes ? (
          <p class="field-fault" id={scopesFault}>
            {made.faults.scopes}
          </p>
        ) : null}
      </fieldset>
      <Choice label={text.life} value={made.days} onChoose={made.setDays} options={Object.entries(text.lives)} />
      <CurrentPassword value={made.password} onInput={made.setPassword} {...fault(made.faults.password)} />
      {coded ? <CodeField value={made.code} onInput={made.setCode} {...fault(made.faults.code)} /> : null}
    </Form>
  );
}

function useCreate(coded: boolean, onDone: CreateProps["onDone"]) {
  const app = useApp();
  const [name, setName] = useState("");
  const [scopes, setScopes] = useState<readonly TokenScope[]>(["read"]);
  const [days, setDays] = useState("30");
  const [password, setPassword] = useState("");
  const [code, setCode] = useState("");
  const [faults, setFaults] = useState<Faults<Given>>({});
  const [busy, setBusy] = useState(false);
  const choose = (scope: TokenScope, on: boolean) =>
    setScopes(tokenScopes.filter((one) => (one === scope ? on : scopes.includes(one))));
  const submit = async () => {
    const found: Faults<Given> = {
      ...(name.trim() === "" ? { name: t.account.required } : {}),
      ...(scopes.length === 0 ? { scopes: t.apiTokens.noScope } : {}),
      ...(password === "" ? { password: t.account.required } : {}),
      ...(coded && code.trim() === "" ? { code: t.account.required } : {}),
    };
    setFaults(found);
    if (Object.keys(found).length > 0) return;
    setBusy(true);
    try {
      const order = { name: name.trim(), scopes, days: Number(days), password };
      onDone(await app.api.tokens.create(coded ? { ...order, code: code.trim() } : order));
    } catch (thrown) {
      const wrongCode = thrown instanceof ApiProblem && thrown.kind === "wrong-code";
      setFaults(
        wrongCode ? { code: problemText(thrown) } : faultsOf(thrown, ["name", "password"], (what) => app.explain(what)),
      );
      setBusy(false);
    }
  };
  return { name, setName, scopes, choose, days, setDays, password, setPassword, code, setCode, faults, busy, submit };
}
