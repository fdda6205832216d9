import type { ComponentChildren } from "preact";

export interface TableProps {
  readonly label: string;
  /** What stands above each column; on a narrow window, before each value. */
  readonly heads: readonly string[];
  readonly rows: readonly { readonly key: string; readonly cells: readonly ComponentChildren[] }[];
}

/**
 * Rows and columns; where the window is narrow, each row a card. Wider than its place it scrolls inside of it, by keys too.
 * The roles are said, since a table that is laid out as cards is none for a browser.
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
