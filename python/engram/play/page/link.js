// Connection to the server: texts are messages, bytes are a header and pictures.
const listeners = new Map();
let socket = null;

export function on(type, listener) { listeners.set(type, listener); }

function dispatch(type, ...values) {
  const listener = listeners.get(type);
  if (listener) listener(...values);
}

export function send(message) {
  if (socket && socket.readyState === WebSocket.OPEN) socket.send(JSON.stringify(message));
}

// A message of bytes: length of the header, the header, files of the sizes in it.
function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  let at = 4 + length;
  const files = header.sizes.map((size) => {
    const file = new Blob([new Uint8Array(buffer, at, size)], { type: 'image/jpeg' });
    at += size;
    return file;
  });
  return [header, files];
}

export function connect() {
  const address = new URL('socket', location.href);
  address.protocol = 'ws:';
  address.hash = '';
  socket = new WebSocket(address);
  socket.binaryType = 'arraybuffer';
  socket.addEventListener('message', (event) => {
    if (typeof event.data === 'string') {
      const message = JSON.parse(event.data);
      dispatch(message.type, message);
    } else {
      const [header, files] = unpack(event.data);
      dispatch('picture ' + header.kind, header, files);
    }
  });
  socket.addEventListener('close', (event) => dispatch('closed', event.code));
}
