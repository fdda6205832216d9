import { t } from "../texts";

/** Shown while the first data of a page or a list is loading. */
export function Loading({ page = false }: { readonly page?: boolean }) {
  return (
    <p class={page ? "page muted" : "muted"} role="status">
      {t.loading}
    </p>
  );
}
