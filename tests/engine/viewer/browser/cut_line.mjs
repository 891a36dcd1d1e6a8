// A line between the page and a server that a test can cut and lead elsewhere. It keeps no process alive.

import { connect, createServer } from "node:net";

export async function openLine(port) {
  const sockets = new Set();
  let target = port;
  const server = createServer((client) => {
    const far = connect(target, "127.0.0.1");
    for (const socket of [client, far]) {
      socket.unref();
      sockets.add(socket);
      socket.on("error", () => {});
      socket.on("close", () => {
        sockets.delete(socket);
        client.destroy();
        far.destroy();
      });
    }
    client.pipe(far);
    far.pipe(client);
  });
  server.unref();
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return {
    port: server.address().port,
    // The address of a page, through this line.
    address: (address) => {
      const url = new URL(address);
      url.port = String(server.address().port);
      return url.href;
    },
    cut: () => sockets.forEach((socket) => socket.destroy()),
    leadTo: (other) => (target = other),
    close: () => {
      sockets.forEach((socket) => socket.destroy());
      return new Promise((resolve) => server.close(resolve));
    },
  };
}
