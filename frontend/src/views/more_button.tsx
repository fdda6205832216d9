import { t } from "../texts";

/** A button that loads the next page of a list. */
export function MoreButton({ onClick }: { readonly onClick: () => void }) {
  return (
    <p>
      <button type="button" class="button" onClick={onClick}>
        {t.admin.more}
      </button>
    </p>
  );
}
