import { t } from "../texts";
import { Field } from "./field";
import { strengthOf } from "./strength";

export interface NewPasswordProps {
  readonly label: string;
  readonly value: string;
  readonly onInput: (value: string) => void;
  readonly fault?: string;
}

/** A field for a new password, with an assessment while the user types. */
export function NewPassword(props: NewPasswordProps) {
  const { level, missing } = strengthOf(props.value);
  const message = missing > 0 ? t.account.passwordMissing(missing) : t.account.passwordLevels[level];
  return (
    <div class="new-password">
      <Field {...props} type="password" autocomplete="new-password" hint={t.account.passwordHint} />
      {props.value === "" ? null : (
        <p class="strength" role="status">
          <meter min={0} max={3} low={1} high={2} optimum={3} value={level} aria-hidden="true" />
          <span>{message}</span>
        </p>
      )}
    </div>
  );
}
