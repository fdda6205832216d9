import type { ComponentChildren } from "preact";

export interface TableProps {
  readonly label: string;
  /** The headings of the columns. In a narrow window, they precede each value. */
  readonly heads: readonly string[];
  readonly rows: readonly { readonly key: string; readonly cells: readonly ComponentChildren[] }[];
}

/**
 * A table. In a narrow window, each row becomes a card. A table that is too wide scrolls in place, also by keyboard.
 * The roles are explicit, because browsers do not treat a table that is laid out as cards as one.
 */
export function Table({ label, heads, rows }: TableProps) {
  return (
    <div class="table-box" tabIndex={0} role="region" aria-label={label}>
      <table role="table" aria-label={label}>
        <thead role="rowgroup">
          <tr role="row">
            {heads.map((head) => (
              <th key={head} role="columnheader" scope="col">
                {head}
              </th>
            ))}
          </tr>
        </thead>
        <tbody role="rowgroup">
          {rows.map(({ key, cells }) => (
            <tr key={key} role="row">
              {cells.map((cell, n) => (
                <td key={heads[n]} role="cell" data-head={heads[n]}>
                  {cell}
                </td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
