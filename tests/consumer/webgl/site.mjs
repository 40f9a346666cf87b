// SPDX-License-Identifier: MIT
import { createServer } from "node:http";
import { extname } from "node:path";

/** Runs use(address) while a server of this machine alone answers with read(path): bytes, or undefined where there is nothing. */
export async function withSite(read, use) {
  const server = createServer((request, response) => {
    const asked = decodeURIComponent(new URL(request.url, "http://localhost").pathname);
    const path = asked === "/" ? "/index.html" : asked;
    const bytes = read(path);
    if (bytes === undefined) return response.writeHead(path === "/favicon.ico" ? 204 : 404).end();
    const type = { ".html": "text/html", ".js": "text/javascript" }[extname(path)] ?? "application/octet-stream";
    return response.writeHead(200, { "content-type": type }).end(bytes);
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  try {
    return await use(`http://127.0.0.1:${server.address().port}/`);
  } finally {
    server.close();
    server.closeAllConnections();
  }
}
