import { useEffect, useState } from "preact/hooks";

interface Drawn {
  readonly size: number;
  readonly path: string;
}

/** The light margin in modules that the standard requires (ISO/IEC 18004, 6.3.8). */
const quiet = 4;

/**
 * A QR code, drawn by a library that is loaded on demand. It is always dark on light, as readers
 * require.
 */
export function QrCode({ text, label }: { readonly text: string; readonly label: string }) {
  const [drawn, setDrawn] = useState<Drawn | null>(null);
  useEffect(() => {
    let here = true;
    void import("uqr").then(({ encode }) => {
      if (!here) return;
      const { data, size } = encode(text, { ecc: "M", border: quiet });
      const dark = data.flatMap((row, y) => row.flatMap((on, x) => (on ? [`M${x} ${y}h1v1h-1z`] : [])));
      setDrawn({ size, path: dark.join("") });
    });
    return () => {
      here = false;
    };
  }, [text]);
  return (
    <svg
      class="qr"
      viewBox={`0 0 ${drawn?.size ?? 1} ${drawn?.size ?? 1}`}
      role="img"
      aria-label={label}
      shape-rendering="crispEdges"
    >
      {drawn ? <path d={drawn.path} /> : null}
    </svg>
  );
}
