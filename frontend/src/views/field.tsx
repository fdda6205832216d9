import { useId, useState } from "preact/hooks";
import { t } from "../texts";
import { Icon } from "./icons";

export interface FieldProps {
  readonly label: string;
  readonly value: string;
  readonly onInput: (value: string) => void;
  readonly type?: "text" | "email" | "password" | "date";
  readonly autocomplete?: string;
  readonly hint?: string;
  readonly fault?: string;
  readonly placeholder?: string;
  readonly most?: number;
  /** Shows a keyboard of digits on devices with an on-screen keyboard. */
  readonly digits?: boolean;
  /** Turns off autocorrection and other help with words. */
  readonly verbatim?: boolean;
}

/** The properties that a field of a fixed kind does not set itself. */
interface KnownFieldProps extends Pick<FieldProps, "value" | "onInput" | "fault"> {
  readonly label?: string;
}

/** An email address. `autocomplete`: "username" to sign in, "email" for a new address. */
export function EmailField(props: KnownFieldProps & { readonly autocomplete: "username" | "email" }) {
  return <Field label={t.account.email} type="email" {...props} />;
}

/** The current password of the account. */
export function CurrentPassword(props: KnownFieldProps) {
  return <Field label={t.myAccount.current} type="password" autocomplete="current-password" {...props} />;
}

/** A labelled input with its hint and its error, connected for screen readers. */
export function Field(props: FieldProps) {
  const id = useId();
  const [shown, setShown] = useState(false);
  const secret = props.type === "password";
  const type = (secret && shown ? "text" : (props.type ?? "text")) as "text"; // the types of JSX require a literal
  const described = [props.fault ? `${id}-fault` : "", props.hint ? `${id}-hint` : ""].filter(Boolean).join(" ");
  return (
    <div class="field">
      <label for={id}>{props.label}</label>
      <div class="field-box">
        <input
          id={id}
          type={type}
          value={props.value}
          onInput={(event) => props.onInput(event.currentTarget.value)}
          aria-invalid={props.fault ? true : undefined}
          {...(described ? { "aria-describedby": described } : {})}
          {...(props.autocomplete ? { autocomplete: props.autocomplete } : {})}
          {...(props.placeholder ? { placeholder: props.placeholder } : {})}
          {...(props.most ? { maxLength: props.most } : {})}
          {...(props.digits ? { inputMode: "numeric" as const } : {})}
          {...(props.verbatim ? { autocapitalize: "none", spellcheck: false } : {})}
          {...(props.type === "email"
            ? { inputMode: "email" as const, autocapitalize: "none", spellcheck: false }
            : {})}
        />
        {secret ? (
          <button
            type="button"
            class="icon-button"
            aria-label={shown ? t.account.hide : t.account.show}
            title={shown ? t.account.hide : t.account.show}
            onClick={() => setShown(!shown)}
          >
            <Icon name={shown ? "eye_off" : "eye"} />
          </button>
        ) : null}
      </div>
      {props.fault ? (
        <p class="field-fault" id={`${id}-fault`}>
          {props.fault}
        </p>
      ) : null}
      {props.hint ? (
        <p class="field-hint" id={`${id}-hint`}>
          {props.hint}
        </p>
      ) : null}
    </div>
  );
}
