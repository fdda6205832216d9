import { t } from "../texts";
import { Field } from "./field";

export interface CodeFieldProps {
  readonly value: string;
  readonly onInput: (value: string) => void;
  /** Whether a recovery code is expected instead of one from the app. */
  readonly recovery?: boolean;
  readonly fault?: string;
}

/** A one-time code: six digits, or a recovery code. */
export function CodeField({ value, onInput, recovery, fault }: CodeFieldProps) {
  return (
    <Field
      label={recovery ? t.secondFactor.recoveryCode : t.secondFactor.code}
      hint={recovery ? t.secondFactor.recoveryCodeHint : t.secondFactor.codeHint}
      value={value}
      onInput={onInput}
      most={40}
      {...(recovery ? { autocomplete: "off", verbatim: true } : { autocomplete: "one-time-code", digits: true })}
      {...(fault ? { fault } : {})}
    />
  );
}
