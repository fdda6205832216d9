import { useEffect, useState } from "preact/hooks";
import { t } from "../texts";

/** A server that answers normally does so much earlier. */
const slowAfterMs = 3000;

/** Shown while the first data of a page or a list is loading. Says so if the server is slow. */
export function Loading({ page = false }: { readonly page?: boolean }) {
  const [isSlow, setSlow] = useState(false);
  useEffect(() => {
    const timer = setTimeout(() => setSlow(true), slowAfterMs);
    return () => clearTimeout(timer);
  }, []);
  return (
    <p class={page ? "page muted" : "muted"} role="status">
      {isSlow ? t.loadingSlow : t.loading}
    </p>
  );
}
