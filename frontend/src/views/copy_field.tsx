import { Icon } from "./icons";

export interface CopyFieldProps {
  readonly value: string;
  readonly label: string;
  /** The text of the button. */
  readonly button: string;
  readonly onCopy: () => void;
}

/** A text to copy. A click selects all of it, for browsers that do not let a page copy. */
export function CopyField({ value, label, button, onCopy }: CopyFieldProps) {
  return (
    <div class="share-row">
      <input type="text" readOnly value={value} aria-label={label} onFocus={(event) => event.currentTarget.select()} />
      <button type="button" class="button" onClick={onCopy}>
        <Icon name="copy" />
        {button}
      </button>
    </div>
  );
}
