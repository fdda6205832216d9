import { useId, useState } from "preact/hooks";
import { t } from "../texts";
import { AccountFrame } from "./account_frame";
import { Form, fault, faultsOf, type Faults } from "./form";
import { Link, navigate } from "./router";
import { useApp } from "./state";

interface ConsentBoxProps {
  readonly given: boolean;
  readonly onChange: (given: boolean) => void;
  readonly fault?: string;
}

/** Asks for the consent to the processing of health data. It is never ticked by default. */
export function ConsentBox({ given, onChange, fault: wrong }: ConsentBoxProps) {
  const id = useId();
  return (
    <div class="field consent">
      <label class="switch">
        <input
          type="checkbox"
          checked={given}
          onChange={(event) => onChange(event.currentTarget.checked)}
          {...(wrong ? { "aria-invalid": true, "aria-describedby": `${id}-fault` } : {})}
        />
        <span>{t.consent.agree}</span>
      </label>
      {wrong ? (
        <p class="field-fault" id={`${id}-fault`}>
          {wrong}
        </p>
      ) : null}
      {/* The notice opens in its own tab, so that the form keeps what has been entered. */}
      <a href="/privacy" target="_blank" rel="noopener">
        {t.consent.notice}
      </a>
    </div>
  );
}

/** Replaces the page for users who have not agreed to the current privacy notice. */
export function ConsentFirst({ version }: { readonly version: string }) {
  const app = useApp();
  const [given, setGiven] = useState(false);
  const [faults, setFaults] = useState<Faults<"consent">>({});
  const [busy, setBusy] = useState(false);
  const submit = async () => {
    setFaults(given ? {} : { consent: t.consent.missing });
    if (!given) return;
    setBusy(true);
    try {
      await app.api.giveConsent(version);
      await app.load();
    } catch (thrown) {
      setFaults(faultsOf(thrown, [], (what) => app.explain(what)));
      setBusy(false);
    }
  };
  const signOut = () =>
    void app
      .signOut()
      .catch(() => undefined)
      .then(() => navigate("/"));
  return (
    <AccountFrame title={t.consent.title} lead={t.consent.lead}>
      <Form onSubmit={submit} busy={busy} label={t.consent.go} {...fault(faults.form)}>
        <ConsentBox given={given} onChange={setGiven} {...fault(faults.consent)} />
      </Form>
      <p class="muted">{t.consent.otherwise}</p>
      <p class="buttons">
        <button type="button" class="button button-small" onClick={signOut}>
          {t.nav.signOut}
        </button>
        <Link href="/account" class="button button-small">
          {t.nav.account}
        </Link>
      </p>
    </AccountFrame>
  );
}
