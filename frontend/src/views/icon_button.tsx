import { Icon, type IconName } from "./icons";

export interface IconButtonProps {
  readonly icon: IconName;
  /** The accessible name, which is also the tooltip. */
  readonly label: string;
  /** A tooltip that differs from the name. */
  readonly title?: string;
  /** Further classes. */
  readonly class?: string;
  readonly disabled?: boolean;
  readonly onClick: () => void;
}

/** A button that shows only an icon. */
export function IconButton({ icon, label, title = label, disabled = false, onClick, ...props }: IconButtonProps) {
  return (
    <button
      type="button"
      class={props.class === undefined ? "icon-button" : `icon-button ${props.class}`}
      aria-label={label}
      title={title}
      disabled={disabled}
      onClick={onClick}
    >
      <Icon name={icon} />
    </button>
  );
}
