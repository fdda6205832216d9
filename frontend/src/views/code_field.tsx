import { t } from "../texts";
import { Field } from "./field";

export interface CodeFieldProps {
  readonly value: string;
  readonly onInput: (value: string) => void;
  /** A recovery code in place of the device's. */
  readonly recovery?: boolean;
  readonly fault?: string;
}

/** A one-time code: six digits, or a recovery code. */
export function CodeField({ value, onInput, recovery, fault }: CodeFieldProps) {
  return (
    <Field
      label={recovery ? t.second_factor.recovery_code : t.second_factor.code}
      hint={recovery ? t.second_factor.recovery_code_hint : t.second_factor.code_hint}
      value={value}
      onInput={onInput}
      most={40}
      {...(recovery ? { autocomplete: "off", verbatim: true } : { autocomplete: "one-time-code", digits: true })}
      {...(fault ? { fault } : {})}
    />
  );
}
